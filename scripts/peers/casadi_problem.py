"""A problem of a small closed-form system, as conddp expands it, as a nonlinear program of CasADi:
states and controls knot by knot, the structure that fatrop detects."""

import fnmatch

import casadi
import numpy

from casadi_pose import between, moved, rate_of_twist, rotation
from conddp_tool import Untranslatable, columns, expanded


def pendulum(p, x, u):
    return [x[1], (u[0] - p["mass"] * p["gravity"] * p["length"] * casadi.sin(x[0])
                   - p["damping"] * x[1]) / p["inertia"]]


def cartpole(p, x, u):
    s, c = casadi.sin(x[1]), casadi.cos(x[1])
    mass, length, gravity = p["pole_mass"], p["length"], p["gravity"]
    scale = 1 / (p["cart_mass"] + mass * s * s)
    push = u[0] + mass * length * s * x[3] ** 2
    return [x[2], x[3], scale * (push + mass * gravity * s * c),
            -scale / length * (push * c + (p["cart_mass"] + mass) * gravity * s)]


def acrobot(p, x, u):
    """Of the mass matrix [[a, b], [b, d]], with the masses at the ends of the links."""
    l1, l2, m1, m2 = p["length1"], p["length2"], p["mass1"], p["mass2"]
    g, both = p["gravity"], m2 * p["length1"] * p["length2"]
    d = m2 * l2 * l2 + p["inertia2"]
    a = (m1 + m2) * l1 * l1 + d + p["inertia1"] + 2 * both * casadi.cos(x[1])
    b = d + both * casadi.cos(x[1])
    h = both * casadi.sin(x[1])
    outer = m2 * l2 * g * casadi.cos(x[0] + x[1])
    first = (h * x[3] ** 2 + 2 * h * x[2] * x[3] - (m1 + m2) * l1 * g * casadi.cos(x[0]) - outer
             - p["friction"] * x[2])
    second = u[0] - h * x[2] ** 2 - outer - p["friction"] * x[3]
    determinant = a * d - b * b
    return [x[2], x[3], (d * first - b * second) / determinant,
            (a * second - b * first) / determinant]


def unicycle(_, x, u):
    return [u[0] * casadi.cos(x[2]), u[0] * casadi.sin(x[2]), u[1]]


def double_integrator(_, x, u):
    n = u.numel()
    return [*casadi.vertsplit(x[n:]), *casadi.vertsplit(u)]


def quadrotor(p, x, u):
    """Of position, unit quaternion and twist; thrusts push along the body's z."""
    v, w = x[7:10], x[10:13]
    gravity = -p["gravity"] * rotation(x[3:7])[2, :].T
    linear = gravity - casadi.cross(w, v) + casadi.vertcat(0, 0, casadi.sum1(u) / p["mass"])
    inertia = casadi.vertcat(p["jx"], p["jy"], p["jz"])
    moment = casadi.vertcat(p["arm"] * (u[1] - u[3]), p["arm"] * (u[2] - u[0]),
                            p["torque_ratio"] * (u[0] - u[1] + u[2] - u[3]))
    angular = (moment - casadi.cross(w, inertia * w)) / inertia
    return casadi.vertsplit(casadi.vertcat(v, w, linear, angular))


RATES = {"pendulum": pendulum, "cartpole": cartpole, "acrobot": acrobot, "unicycle": unicycle,
         "double_integrator": double_integrator, "quadrotor": quadrotor}
#: Systems whose state begins with a pose and has one direction less than numbers.
ON_POSES = ("quadrotor",)
RULES = {"rk3": (((), (0.5,), (-1, 2)), (1 / 6, 4 / 6, 1 / 6)),
         "rk4": (((), (0.5,), (0, 0.5), (0, 0, 1)), (1 / 6, 2 / 6, 2 / 6, 1 / 6))}


class Program:
    """The nonlinear program of a problem file. With calls, one function of a knot is called for each; else
    each knot has expressions of its own, which CasADi differentiates better but a compiler digests slowly."""

    def __init__(self, file, overrides=(), calls=False):
        problem = self.problem = expanded(file, overrides)
        self.states, self.controls = columns(file, overrides)
        self.on_poses = problem["system"]["type"] in ON_POSES
        self.direction_names = self._direction_names()
        if len(problem["phases"]) != 1 or problem["running_costs"] != "rate":
            raise Untranslatable("several phases")
        if problem["controls"] != "constant":
            raise Untranslatable("linear controls")
        phase, = problem["phases"]
        self.knots, self.dt = phase["knots"], phase["dt"]
        self.symbols = casadi.MX if calls else casadi.SX
        self.z, self.rows = [], []
        self.lower, self.upper, self.equality = [], [], []
        self.cost = 0
        step, stages = self._step(), {}
        x = self._new("x0", len(self.states))
        start = self.values(problem["initial_state"], self.states)
        waiting = [(x - casadi.DM(start), [0] * len(start), [0] * len(start))]
        for k in range(self.knots):
            u = self._new(f"u{k}", len(self.controls))
            key = k if any(k in term.get("knots", ()) for term in problem["costs"].values()) else None
            if key not in stages:
                stages[key] = self._stage(problem, self.dt, key, has_controls=True)
            waiting.append(self._evaluated(stages[key], x, u))
            following = self._new(f"x{k + 1}", len(self.states))
            # fatrop wants the dynamics of a knot in front of its other rows.
            self._write(following - step(x, u), [0] * len(start), [0] * len(start))
            for rows in waiting:
                self._write(*rows)
            waiting = []
            x = following
        self._write(*self._evaluated(self._stage(problem["terminal"], 1, None, has_controls=False), x, []))

    def _direction_names(self):
        if not self.on_poses:
            return self.states
        return [*self.states[:3], "rx", "ry", "rz", *self.states[7:]]

    def _new(self, name, size):
        symbol = self.symbols.sym(name, size)
        self.z.append(symbol)
        return symbol

    def _write(self, rows, lower, upper):
        self.rows.append(rows)
        self.lower += lower
        self.upper += upper
        self.equality += [a == b for a, b in zip(lower, upper)]

    def _step(self):
        system = self.problem["system"]
        if system["type"] not in RATES or self.problem["integrator"] not in RULES:
            raise Untranslatable(f"{system['type']} by {self.problem['integrator']}")
        x, u = casadi.SX.sym("x", len(self.states)), casadi.SX.sym("u", len(self.controls))
        rate = casadi.Function("rate", [x, u], [casadi.vertcat(*RATES[system["type"]](system, x, u))])
        stages, weights = RULES[self.problem["integrator"]]
        slopes = []

        def change(row):
            total = casadi.SX(len(self.direction_names), 1)
            return self.dt * sum((a * k for a, k in zip(row, slopes) if a), total)

        for row in stages:
            by = change(row)
            slopes.append(self._slope(by, rate(self._displaced(x, by), u)))
        return casadi.Function("step", [x, u], [self._displaced(x, change(weights))])

    def _displaced(self, x, change):
        if not self.on_poses:
            return x + change
        return casadi.vertcat(moved(x[:7], change[:6]), x[7:] + change[6:])

    def _slope(self, change, rate):
        """Of the change of a state that moves with a rate."""
        if not self.on_poses:
            return rate
        return casadi.vertcat(rate_of_twist(change[:6], rate[:6]), rate[6:])

    @staticmethod
    def values(given, names, default=0.0):
        """Numbers by component: one for all, a list, or by name."""
        if isinstance(given, (int, float)):
            return [given] * len(names)
        if isinstance(given, list):
            return given
        if "state" in given:
            return given["state"]
        by_name = given.get("values", given)
        by_name = {"qw": 1.0, **by_name}  # no turn unless it is named
        return [next((value for pattern, value in by_name.items() if fnmatch.fnmatchcase(name, pattern)), default)
                for name in names]

    def _residual(self, term, x, u, knot):
        if term["residual"] == "control":
            return u - casadi.DM(self.values(term["reference"], self.controls))
        if term["residual"] != "state":
            raise Untranslatable(f"the residual {term['residual']}")
        columns = term.get("columns", self.states)
        columns = [columns] if isinstance(columns, str) else columns
        chosen = casadi.vertcat(*(x[self.states.index(name)] for name in columns))
        if "centers" in term:
            return [chosen - casadi.DM(centre) for centre in term["centers"]]
        reference = term["reference"]
        if isinstance(reference, dict) and "knots" in reference:
            reference = reference["values"][reference["knots"].index(knot)]
        reference = casadi.DM(self.values(reference, columns))
        if self.on_poses and len(columns) == len(self.states):
            return casadi.vertcat(between(reference, x), x[7:] - reference[7:])
        return chosen - reference

    def _stage(self, part, scale, knot, has_controls):
        """Cost and rows of a knot as a function of its state and controls, and the rows' limits."""
        x = casadi.SX.sym("x", len(self.states))
        u = casadi.SX.sym("u", len(self.controls) if has_controls else 0)
        cost = casadi.SX(0)
        for term in part["costs"].values():
            if term["activation"] != "quadratic":
                raise Untranslatable(f"the activation {term['activation']}")
            if "knots" in term and knot not in term["knots"]:
                continue
            r = self._residual(term, x, u, knot)
            names = self.controls if term["residual"] == "control" else self.direction_names
            weights = casadi.DM(self.values(term["weights"], names, 1.0))
            cost += 0.5 * scale * term["weight"] * casadi.dot(weights, r * r)
        rows = [row for term in part["constraints"].values() for row in self._constraint(term, x, u, knot)]
        values, lower, upper = zip(*rows) if rows else ((), (), ())
        return casadi.Function("stage", [x, u], [cost, casadi.vertcat(*values)]), list(lower), list(upper)

    def _evaluated(self, stage, x, u):
        """The rows of a knot; its cost is added."""
        function, lower, upper = stage
        cost, rows = function(x, u)
        self.cost += cost
        return rows, lower, upper

    def _constraint(self, term, x, u, knot):
        if "bounds" in term:
            names = self.controls if term["bounds"] == "control" else self.states
            values = u if term["bounds"] == "control" else x[len(self.states) // 2:]
            names = names if term["bounds"] == "control" else names[len(names) // 2:]
            if u.numel() == 0:
                return []  # bounds on velocities hold at running knots
            lower, upper = (self.values(term[side], names) for side in ("lower", "upper"))
            return [(values[i], lower[i], upper[i]) for i in range(len(names))]
        r = self._residual(term, x, u, knot)
        if "at_least" in term:
            return [(casadi.dot(row, row), term["at_least"] ** 2, casadi.inf)
                    for row in (r if isinstance(r, list) else [r])]
        if "equals" in term:
            return [(r[i] - wanted, 0, 0)
                    for i, wanted in enumerate(self.values(term["equals"], casadi.vertsplit(r)))]
        raise Untranslatable("bounds on a residual")

    def point(self, trajectory):
        """A trajectory of bench_solve_times as the program's variables."""
        parts = []
        for x, u in zip(trajectory["x"], [*trajectory["u"], []]):
            parts += [*x, *u]
        return numpy.array(parts)

    def nlp(self):
        return {"x": casadi.vertcat(*self.z), "f": self.cost, "g": casadi.vertcat(*self.rows)}

    def violation(self, values):
        """The largest violation of rows."""
        return max(0, float(numpy.max(numpy.array(self.lower) - values)),
                   float(numpy.max(values - numpy.array(self.upper))))

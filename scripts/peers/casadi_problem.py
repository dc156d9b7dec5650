"""A problem of a small closed-form system, as conddp expands it, as a nonlinear program of CasADi:
states and controls knot by knot, the structure that fatrop detects."""

import casadi
import numpy

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


RATES = {"pendulum": pendulum, "cartpole": cartpole, "acrobot": acrobot, "unicycle": unicycle,
         "double_integrator": double_integrator}
RULES = {"rk3": (((), (0.5,), (-1, 2)), (1 / 6, 4 / 6, 1 / 6)),
         "rk4": (((), (0.5,), (0, 0.5), (0, 0, 1)), (1 / 6, 2 / 6, 2 / 6, 1 / 6))}


class Program:
    """The nonlinear program of a problem file."""

    def __init__(self, file, overrides=()):
        problem = self.problem = expanded(file, overrides)
        self.states, self.controls = columns(file, overrides)
        if len(problem["phases"]) != 1 or problem["running_costs"] != "rate":
            raise Untranslatable("several phases")
        if problem["controls"] != "constant":
            raise Untranslatable("linear controls")
        phase, = problem["phases"]
        self.knots, self.dt = phase["knots"], phase["dt"]
        self.z, self.rows = [], []
        self.lower, self.upper, self.equality = [], [], []
        self.cost = 0
        step = self._step()
        x = self._new("x0", len(self.states))
        self._start(x)
        for k in range(self.knots):
            u = self._new(f"u{k}", len(self.controls))
            self._terms(problem, x, u, self.dt)
            following = self._new(f"x{k + 1}", len(self.states))
            # fatrop wants the dynamics of a knot in front of its other rows.
            self._insert_dynamics(following - step(x, u))
            x = following
        self._terms(problem["terminal"], x, None, 1)
        self._flush()

    def _new(self, name, size):
        symbol = casadi.SX.sym(name, size)
        self.z.append(symbol)
        return symbol

    def _add(self, row, lower, upper):
        """A row of the knot at hand."""
        self.waiting.append((row, lower, upper))

    waiting = ()

    def _start(self, x):
        self.waiting = []
        start = self.values(self.problem["initial_state"], self.states)
        for i, value in enumerate(start):
            self._add(x[i] - value, 0, 0)

    def _insert_dynamics(self, gap):
        for row in casadi.vertsplit(gap):
            self._write(row, 0, 0)
        self._flush()

    def _write(self, row, lower, upper):
        self.rows.append(row)
        self.lower.append(lower)
        self.upper.append(upper)
        self.equality.append(lower == upper)

    def _flush(self):
        for row in self.waiting:
            self._write(*row)
        self.waiting = []

    def _step(self):
        system = self.problem["system"]
        if system["type"] not in RATES or self.problem["integrator"] not in RULES:
            raise Untranslatable(f"{system['type']} by {self.problem['integrator']}")
        x, u = casadi.SX.sym("x", len(self.states)), casadi.SX.sym("u", len(self.controls))
        rate = casadi.Function("rate", [x, u], [casadi.vertcat(*RATES[system["type"]](system, x, u))])
        stages, weights = RULES[self.problem["integrator"]]
        slopes = []
        for row in stages:
            at = x + self.dt * sum((a * k for a, k in zip(row, slopes)), casadi.SX(0))
            slopes.append(rate(at, u))
        moved = x + self.dt * sum(w * k for w, k in zip(weights, slopes))
        return casadi.Function("step", [x, u], [moved])

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
        return [by_name.get(name, default) for name in names]

    def _residual(self, term, x, u):
        if term["residual"] == "control":
            return u - casadi.DM(self.values(term["reference"], self.controls))
        if term["residual"] != "state":
            raise Untranslatable(f"the residual {term['residual']}")
        columns = term.get("columns", self.states)
        columns = [columns] if isinstance(columns, str) else columns
        chosen = casadi.vertcat(*(x[self.states.index(name)] for name in columns))
        if "centers" in term:
            return [chosen - casadi.DM(centre) for centre in term["centers"]]
        return chosen - casadi.DM(self.values(term["reference"], columns))

    def _terms(self, part, x, u, scale):
        for term in part["costs"].values():
            if term["activation"] != "quadratic" or "knots" in term:
                raise Untranslatable(f"the activation {term['activation']}")
            r = self._residual(term, x, u)
            names = self.controls if term["residual"] == "control" else self.states
            weights = casadi.DM(self.values(term["weights"], names, 1.0))
            self.cost += 0.5 * scale * term["weight"] * casadi.dot(weights, r * r)
        for term in part["constraints"].values():
            self._constraint(term, x, u)

    def _constraint(self, term, x, u):
        if "bounds" in term:
            names = self.controls if term["bounds"] == "control" else self.states
            values = u if term["bounds"] == "control" else x[len(self.states) // 2:]
            names = names if term["bounds"] == "control" else names[len(names) // 2:]
            if u is None:
                return  # bounds on velocities hold at running knots
            lower, upper = (self.values(term[side], names) for side in ("lower", "upper"))
            for i in range(len(names)):
                self._add(values[i], lower[i], upper[i])
            return
        r = self._residual(term, x, u)
        if "at_least" in term:
            for row in r if isinstance(r, list) else [r]:
                self._add(casadi.dot(row, row), term["at_least"] ** 2, casadi.inf)
        elif "equals" in term:
            for i, wanted in enumerate(self.values(term["equals"], casadi.vertsplit(r))):
                self._add(r[i] - wanted, 0, 0)
        else:
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

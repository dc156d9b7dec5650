"""The problems of composed_problem.py as nonlinear programs of CasADi."""

import math

import casadi
import numpy

RULES = {"explicit_euler": ((), (1,)), "rk4": ((0.5, 0.5, 1), (1 / 6, 2 / 6, 2 / 6, 1 / 6))}
FUNCTIONS = {name: getattr(casadi, name) for name in ("sin", "cos", "tanh", "exp")} | {
    "smooth_abs": lambda a, width: casadi.sqrt(a * a + width * width),
    "smooth_norm": lambda v, width: casadi.sqrt(sum(a * a for a in v) + width * width),
}


def values(expression, names):
    return eval(str(expression).replace("^", "**"), {"__builtins__": {}}, {**FUNCTIONS, **names})


def distance(row, lower, upper):
    over = 0 if upper is None else casadi.fmax(0, row - upper)
    return over if lower is None else over + casadi.fmax(0, lower - row)


def smooth(square, width):
    """The root of it and the width's square, less the width, without a difference."""
    return square / (casadi.sqrt(square + width**2) + width)


def activated(term, r):
    kind = term.get("activation", "quadratic")
    options = kind if isinstance(kind, dict) else {"kind": kind}
    width = options.get("epsilon", 0.1)
    return {
        "quadratic": lambda: 0.5 * casadi.sumsqr(r),
        "linear": lambda: casadi.sum1(r),
        "smooth_l1": lambda: casadi.sum1(smooth(r * r, width)),
        "smooth_l2": lambda: smooth(casadi.sumsqr(r), width),
        "quadratic_barrier": lambda: 0.5
        * casadi.sumsqr(distance(r, options["lower"], options["upper"])),
    }[options["kind"]]()


class Program:
    """z is u0, x1, u1, x2, ...; parts are all costs of all nodes, rows first the dynamics."""

    def __init__(self, document):
        self.document = document
        system, phase = document["system"], document["phases"][0]
        self.states, self.controls = system["states"], system["controls"]
        self.knots, self.dt = phase["knots"], phase["dt"]
        self.start = [document["initial_state"]["values"][name] for name in self.states]
        self.step = self._step()
        z, self.parts, gaps, self.constraints, self.limits = [], [], [], [], []
        x = casadi.SX(self.start)
        for k in range(self.knots):
            u, following = (
                casadi.SX.sym(f"{name}{k}", len(of))
                for name, of in (("u", self.controls), ("x", self.states))
            )
            z += [u, following]
            self._node(document, x, u, self.dt)
            self._bounds_of_states(x)
            gaps.append(following - self.step(x, u))
            x = following
        self._node(document["terminal"], x, casadi.SX(0, 1), 1)
        self._bounds_of_states(x)
        self.z, self.parts = casadi.vertcat(*z), casadi.vertcat(*self.parts, 0)
        self.gaps, self.constraints = casadi.vertcat(*gaps), casadi.vertcat(*self.constraints)
        self.distances = casadi.vertcat(
            *(distance(self.constraints[i], *limit) for i, limit in enumerate(self.limits)),
            casadi.SX(0, 1),
        )
        self.evaluated = casadi.Function("at", [self.z], [self.parts, self.gaps, self.distances])

    def _step(self):
        x, u = casadi.SX.sym("x", len(self.states)), casadi.SX.sym("u", len(self.controls))
        rates = self.document["system"]["rate"].values()
        rate = casadi.Function(
            "rate", [x, u], [casadi.vertcat(*(values(r, self._names(x, u)) for r in rates))]
        )
        stages, weights = RULES[self.document["integrator"]]
        slopes = [rate(x, u)]
        for share in stages:
            slopes.append(rate(x + share * self.dt * slopes[-1], u))
        return casadi.Function(
            "step", [x, u], [x + self.dt * sum(w * s for w, s in zip(weights, slopes))]
        )

    def _names(self, x, u):
        return dict(zip(self.states + self.controls, casadi.vertsplit(casadi.vertcat(x, u))))

    def _residual(self, term, x, u):
        rows = {"state": term.get("columns", self.states), "control": self.controls}.get(
            term["residual"], term.get("rows")
        )
        found = casadi.vertcat(*(values(row, self._names(x, u)) for row in rows))
        return found - casadi.DM(term.get("reference", [0] * len(rows)))

    def _node(self, part, x, u, scale):
        for term in part["costs"].values():
            self.parts.append(scale * term["weight"] * activated(term, self._residual(term, x, u)))
        for term in part["constraints"].values():
            if "bounds" in term:
                continue
            r = self._residual(term, x, u)
            limit = (term.get("lower", term.get("at_least")), term.get("upper"))
            if "at_least" in term:
                r = casadi.norm_2(r)
            elif limit == (None, None):
                r, limit = r - casadi.DM(term.get("equals", [0] * r.numel())), (0, 0)
            self._add(r, limit)

    def _bounds_of_states(self, x):
        for term in self.document["constraints"].values():
            if term.get("bounds") == "state":
                for i, name in enumerate(self.states):
                    limit = (term.get("lower", {}).get(name), term.get("upper", {}).get(name))
                    if limit != (None, None):
                        self._add(x[i], limit)

    def _add(self, rows, limit):
        """Rows of the given first state alone are none."""
        for row in casadi.vertsplit(rows):
            if casadi.symvar(row):
                self.constraints.append(row)
                self.limits.append(limit)

    def reach(self):
        """Largest size of a control, by its bounds."""
        return self.document["constraints"].get("reach", {}).get("upper", math.inf)

    def point(self, x, u):
        return numpy.concatenate([numpy.array([*a, *b], float) for a, b in zip(u, x[1:])])

    def trajectory(self, z):
        rows = numpy.reshape(z, (self.knots, -1))
        m = len(self.controls)
        return [self.start, *rows[:, m:].tolist()], rows[:, :m].tolist()

    def simulated(self, u):
        x = [self.start]
        for row in u:
            x.append(numpy.array(self.step(x[-1], row)).ravel().tolist())
        return x

    def without_gaps(self, z):
        """What its controls do. Costs of 10^9 make much of gaps of 10^-12."""
        u = self.trajectory(z)[1]
        return self.point(self.simulated(u), u)

    def at(self, z):
        """Costs part by part, the largest gap and the distances of constraints."""
        parts, gaps, distances = (numpy.array(value).ravel() for value in self.evaluated(z))
        over = numpy.max(numpy.abs(self._controls_of(z))) - self.reach()
        return parts, float(numpy.max(numpy.abs(gaps))), numpy.append(distances, max(0, over))

    def _controls_of(self, z):
        return numpy.reshape(z, (self.knots, -1))[:, : len(self.controls)]

    def ranges(self, z):
        """How far the motion goes in each number; a bound, or about 1, where it hardly does."""
        rows = numpy.reshape(z, (self.knots, -1))
        m = len(self.controls)
        states = numpy.max(numpy.abs(rows[:, m:] - self.start), axis=0)
        controls = numpy.max(numpy.abs(rows[:, :m]), axis=0)
        least = 0.3 * self.reach() if self.reach() < math.inf else 0.3
        sizes = numpy.concatenate([numpy.maximum(controls, least), numpy.maximum(states, 0.3)])
        return numpy.tile(sizes, self.knots)

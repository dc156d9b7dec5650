"""Searches for points of lower cost or violation beside a point, and for feasible points."""

import math

import casadi
import numpy

#: A point is feasible if it violates no row by more.
FEASIBLE = 1e-8
IPOPT = {
    "print_level": 0,
    "sb": "yes",
    "tol": 1e-10,
    "constr_viol_tol": 1e-11,
    "max_iter": 300,
    "acceptable_iter": 0,
    "max_wall_time": 3.0,
    "honor_original_bounds": "yes",
}
QUIET = {"print_time": False, "error_on_fail": False, "show_eval_warnings": False}
WARM = {
    "mu_init": 1e-9,
    "bound_push": 1e-9,
    "bound_frac": 1e-9,
    "slack_bound_push": 1e-9,
    "slack_bound_frac": 1e-9,
}


class Neighbourhood:
    """Minimizes the costs, or the distances from constraints alone, in boxes about a point: of the
    radius times all ranges, in numbers of size 1."""

    def __init__(self, program, of_violation=False):
        self.program, self.of_violation = program, of_violation
        n = program.z.numel()
        e, p = casadi.SX.sym("e", n), casadi.SX.sym("p", 2 * n + 2)
        parts = 0.5 * program.distances**2 if of_violation else program.parts
        rows = program.gaps if of_violation else casadi.vertcat(program.gaps, program.constraints)
        self.parts = casadi.Function("parts", [program.z], [parts])
        self.rows = casadi.Function("rows", [program.z], [rows])
        z = p[:n] + p[n : 2 * n] * e
        at = casadi.substitute(casadi.vertcat(casadi.sum1(parts), rows), program.z, z)
        nlp = {"x": e, "p": p, "f": casadi.densify(at[0] * p[-2]), "g": at[1:] / p[-1]}
        self.solvers = [
            casadi.nlpsol("near", "ipopt", nlp, {**QUIET, "ipopt": {**IPOPT, **more}})
            for more in ({}, WARM)
        ]
        limits = [(0, 0)] * program.gaps.numel() + ([] if of_violation else program.limits)
        self.lower = numpy.array([-math.inf if a is None else a for a, _ in limits], float)
        self.upper = numpy.array([math.inf if b is None else b for _, b in limits], float)

    def size(self, z):
        """Of the costs: the sum of all parts, at least what a move by 3e-7 of all ranges
        changes of them, of which 10^-6 is what conddp counts as none."""
        parts, ranges = numpy.array(self.parts(z)).ravel(), self.program.ranges(z)
        moved = numpy.array(self.parts(z + 3e-7 * ranges)).ravel()
        return max(
            float(numpy.sum(numpy.abs(parts))), float(numpy.sum(numpy.abs(moved - parts))), 1e-300
        )

    def lowest(self, centre, radius, starts, least=0.0):
        """The lowest feasible point found in the box: the gain, as a share of the size, and z.
        The centre itself where none gains more than the least."""
        program, size = self.program, self.size(centre)
        spans = radius * program.ranges(centre)
        m, reach = len(program.controls), program.reach()
        low, high = -numpy.ones(len(centre)), numpy.ones(len(centre))
        of_controls = numpy.arange(len(centre)) % (m + len(program.states)) < m
        low[of_controls] = numpy.maximum(low, (-reach - centre) / spans)[of_controls]
        high[of_controls] = numpy.minimum(high, (reach - centre) / spans)[of_controls]
        best = (least, centre)
        for start, solver in ((start, solver) for start in starts for solver in self.solvers):
            scale = 1 / (size * radius)
            answer = solver(
                x0=numpy.clip(start, low, high),
                p=numpy.concatenate([centre, spans, [scale, radius]]),
                lbx=low,
                ubx=high,
                lbg=self.lower / radius,
                ubg=self.upper / radius,
            )
            found = centre + spans * numpy.clip(numpy.array(answer["x"]).ravel(), low, high)
            forces = numpy.abs(numpy.array(answer["lam_g"]).ravel()) / (scale * radius)
            for point in (found, program.without_gaps(found)):
                gain = self._gain(centre, point, forces) / size
                best = max(best, (gain, point), key=lambda pair: pair[0])
        return best

    def _gain(self, centre, found, forces):
        """What remains of it beside twice what violations may be worth."""
        rows = numpy.array(self.rows(found)).ravel()
        off = numpy.maximum(0, numpy.maximum(self.lower - rows, rows - self.upper))
        if not numpy.all(off <= FEASIBLE):  # also where it is no number
            return -math.inf
        off[off < 1e-15] = 0
        change = numpy.array(self.parts(found)).ravel() - numpy.array(self.parts(centre)).ravel()
        return -math.fsum(change) - 2 * float(numpy.dot(forces, off))

    def descends(self, centre, draw, least, radii=(0.05, 5e-3, 5e-4)):
        """The gain in the largest box, whether it is reached by descent, and the point. It is if
        smaller boxes have their part of it: the square of their size along a curvature, more along
        a slope."""
        size = len(centre)
        ahead = [
            spread * numpy.array([draw.uniform(-1, 1) for _ in range(size)])
            for spread in (0, 0.02, 0.3)
        ]
        gain, found = self.lowest(centre, radii[0], ahead)
        if gain <= least:
            return gain, False, found
        way = (found - centre) / self.program.ranges(centre)
        way /= max(numpy.max(numpy.abs(way)), 1e-30)
        shares = [self.lowest(centre, radius, [0.5 * way, *ahead])[0] for radius in radii[1:]]
        parts = [0.05 * gain * (radius / radii[0]) ** 2 for radius in radii[1:]]
        return gain, all(share > part for share, part in zip(shares, parts)), found


def feasible_point(program, starts):
    """A point that satisfies all rows, near to a start; None if Ipopt finds none."""
    n = program.z.numel()
    p = casadi.SX.sym("p", n)
    rows = casadi.vertcat(program.gaps, program.constraints)
    nlp = {"x": program.z, "p": p, "f": 1e-6 * casadi.sumsqr(program.z - p), "g": rows}
    solver = casadi.nlpsol("feasible", "ipopt", nlp, {**QUIET, "ipopt": IPOPT})
    limits = [(0, 0)] * program.gaps.numel() + program.limits
    box = numpy.where(
        numpy.arange(n) % (len(program.controls) + len(program.states)) < len(program.controls),
        program.reach(),
        math.inf,
    )
    for start in starts:
        answer = solver(
            x0=start,
            p=start,
            lbx=-box,
            ubx=box,
            lbg=[-math.inf if a is None else a for a, _ in limits],
            ubg=[math.inf if b is None else b for _, b in limits],
        )
        z = numpy.array(answer["x"]).ravel()
        _, gap, distances = program.at(z)
        if gap <= FEASIBLE and numpy.max(distances) <= FEASIBLE:
            return z
    return None

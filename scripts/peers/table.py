"""Results as tables in Markdown."""

import math

from figures import number
from solvers import EQUALITY


def ratio(theirs, ours):
    return "–" if math.isnan(theirs) or math.isnan(ours) else f"{number(theirs / ours, 1, 2)}"


def ours_beside(comparison, row):
    return next(other for other in comparison.rows
                if other.solver.startswith("conddp") and other.dropped == row.dropped)


def solver_table(results):
    lines = ["| case | solver | µs a knot, differentiate + sweep + rollout | ratio "
             "| µs a knot and iteration of a whole solve | ratio "
             "| iterations to 1e-9 | ms to 1e-9 | ratio | whole solve, ms (iterations) |",
             "|---|---|---|---|---|---|---|---|---|---|"]
    for comparison in results:
        for i, row in enumerate(comparison.rows):
            ours, scale = ours_beside(comparison, row), 1e6 / comparison.knots
            parts = " + ".join(number(part, scale) for part in row.parts)
            name = row.solver + (", no bounds" if row.dropped else "")
            state = "" if row.converged else ", not converged"
            lines.append(" | ".join([
                f"| {comparison.name + f', N {comparison.knots}' if i == 0 else ''}", name,
                f"{number(row.step, scale)}" + (f" ({parts})" if parts else ""),
                "" if row is ours else ratio(row.step, ours.step),
                number(row.iteration, scale),
                "" if row is ours else ratio(row.iteration, ours.iteration),
                str(row.iterations or "–"), number(row.to_tolerance, 1e3),
                "" if row is ours else ratio(row.to_tolerance, ours.to_tolerance),
                f"{number(row.whole, 1e3)} ({row.whole_iterations}{state}) |"]))
    return "\n".join(lines) + "\n"


def equality_table(results):
    """Whether the problems are the same: costs of the guess and of the optimum."""
    lines = ["| case | solver | cost of the guess | apart | gap of the guess | optimum | apart | same |",
             "|---|---|---|---|---|---|---|---|"]
    for comparison in results:
        for i, row in enumerate(comparison.rows):
            ours = ours_beside(comparison, row)
            apart = [abs(theirs / mine - 1) for theirs, mine in
                     ((row.guess_cost, ours.guess_cost), (row.best_cost, ours.best_cost))]
            gap_agrees = abs(row.guess_gap - ours.guess_gap) <= EQUALITY * max(1, ours.guess_gap)
            same = max(apart) <= EQUALITY and gap_agrees
            lines.append(f"| {comparison.name if i == 0 else ''} | {row.solver} "
                         f"| {row.guess_cost:.12g} | {apart[0]:.0e} | {row.guess_gap:.6g} "
                         f"| {row.best_cost:.12g} | {apart[1]:.0e} | {'yes' if same else '**no**'} |")
    return "\n".join(lines) + "\n"


def kernel_table(robots, build):
    lines = [f"| µs a call | | Pinocchio, {build} | conddp `double` | conddp lanes | Pinocchio / lanes |",
             "|---|---|---|---|---|---|"]
    for robot, rows in robots.items():
        for i, (name, theirs, scalar, lanes) in enumerate(rows):
            lines.append(f"| {robot if i == 0 else ''} | {name} | {number(theirs)} "
                         f"| {number(scalar)} | {number(lanes)} | {ratio(theirs, lanes)} |")
    return "\n".join(lines) + "\n"

"""Reaches of the arm in a loop, as somebody writes it who has one model and many goals: the shooting
problem is made once, goal and initial state are set, and the solver starts from the same guess each
time. usage: batch_loop.py [COUNT]"""

import json
import sys
import time
from importlib.metadata import version

import crocoddyl
import numpy as np
import pinocchio as pin

from conddp_tool import ROOT, expanded
from crocoddyl_problem import Translation

#: Of the expected decrease of the cost: with it answers satisfy the check of conddp (start_runs.py).
STOP = 1e-9
MOST_ITERATIONS = 500


def goals(count):
    """Goals over the rectangle of problems/batches/reach_goals.yaml, and starts near the file's."""
    numbers = np.random.default_rng(7)
    for i in range(count):
        yield (0.3 + 0.15 * (i % 25) / 24, 0.35 + 0.15 * (i // 25 % 20) / 19), \
            0.02 * numbers.uniform(-1, 1, 14)


def main(count):
    problem = expanded(ROOT / "problems" / "arm_reach.yaml")
    shooting = Translation(problem).shooting_problem()
    reference = shooting.terminalModel.differential.costs.costs["tool"].cost.residual
    solver = crocoddyl.SolverBoxFDDP(shooting)
    solver.th_stop = STOP
    start, goal = shooting.x0.copy(), reference.reference.copy()
    solved, began = 0, time.perf_counter()
    for (x, y), change in goals(count):
        shooting.x0 = start + change
        reference.reference = pin.SE3(goal.rotation, np.array([x, y, goal.translation[2]]))
        xs = [shooting.x0] * (shooting.T + 1)
        us = shooting.quasiStatic(xs[:-1])
        solved += solver.solve(xs, us, MOST_ITERATIONS, False)
    seconds = time.perf_counter() - began
    print(json.dumps({"version": version("crocoddyl"), "items": count, "solved": int(solved),
                      "seconds": seconds}))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 500)

"""Instances of a problem that differ in their initial states, in a loop, as somebody writes it who has one model:
the shooting problem is made once, the initial state is set, and the solver starts at rest there.
usage: instance_loop.py PROBLEM.yaml STATES.json"""

import json
import sys
import time
from importlib.metadata import version
from pathlib import Path

import crocoddyl
import numpy as np

from batch_loop import MOST_ITERATIONS, STOP
from conddp_tool import expanded
from crocoddyl_problem import Translation


def main(problem, states):
    shooting = Translation(expanded(problem)).shooting_problem()
    solver = crocoddyl.SolverBoxFDDP(shooting)
    solver.th_stop = STOP
    solved, began = 0, time.perf_counter()
    for state in states:
        shooting.x0 = np.array(state)
        xs = [shooting.x0] * (shooting.T + 1)
        us = shooting.quasiStatic(xs[:-1])
        solved += solver.solve(xs, us, MOST_ITERATIONS, False)
    seconds = time.perf_counter() - began
    print(json.dumps({"version": version("crocoddyl"), "solved": int(solved), "seconds": seconds}))


if __name__ == "__main__":
    main(sys.argv[1], json.loads(Path(sys.argv[2]).read_text(encoding="utf-8")))

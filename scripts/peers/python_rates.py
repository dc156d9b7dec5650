"""Prints the table of docs/measurements/python.md: see scripts/peers/python_rates. Each tool solves one
problem from many starts near the file's, in one thread, as somebody writes it who has one model: what
can be made once is made once, and each solve begins at the same kind of guess."""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import crocoddyl
import numpy as np

import conddp
from conddp_tool import BINARIES, ROOT, expanded
from crocoddyl_problem import Translation

SPREAD = 0.02   # of starts, in the units of the state
STOP = 1e-9     # of Crocoddyl's expected decrease: answers then satisfy the check of conddp
MOST_ITERATIONS = 500
TURNS = 3


def by_package(file, count, verify):
    problem = conddp.load(file)
    many = [{"perturbation": {"initial_state": SPREAD, "seed": seed}} for seed in range(1, count + 1)]
    return sum(a.solved for a in problem.solve_many(many, jobs=1, verify=verify))


def by_batch(file, count):
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan.yaml"
        plan.write_text(
            f"conddp_batch: 1\nproblem: {file}\n"
            f"vary: {{start: {{perturb: initial_state, spread: {SPREAD}, count: {count}}}}}\n")
        subprocess.run([BINARIES / "conddp", "batch", "run", plan, "-j", "1", "-o",
                        Path(folder) / "run"], check=True, capture_output=True)
    return count  # otherwise its exit status is not 0


def by_crocoddyl(file, count):
    shooting = Translation(expanded(file)).shooting_problem()
    solver = crocoddyl.SolverBoxFDDP(shooting)
    solver.th_stop = STOP
    start, numbers, solved = shooting.x0.copy(), np.random.default_rng(1), 0
    for _ in range(count):
        change = SPREAD * numbers.uniform(-1, 1, shooting.runningModels[0].state.ndx)
        shooting.x0 = shooting.runningModels[0].state.integrate(start, change)
        xs = [shooting.x0] * (shooting.T + 1)
        solved += solver.solve(xs, shooting.quasiStatic(xs[:-1]), MOST_ITERATIONS, False)
    return solved


def main(count):
    ways = {
        "conddp in Python, with certificates": lambda file: by_package(file, count, True),
        "conddp in Python, without": lambda file: by_package(file, count, False),
        "`conddp batch run -j 1`": lambda file: by_batch(file, count),
        "Crocoddyl in Python": lambda file: by_crocoddyl(file, count),
    }
    print("| problem | tool | solved | a second |\n|---|---|---|---|")
    for name in ("arm_reach", "quadruped_trot"):
        file = ROOT / "problems" / f"{name}.yaml"
        rates, solved = {way: [] for way in ways}, {}
        for _ in range(TURNS):
            for way, run in ways.items():
                began = time.perf_counter()
                solved[way] = run(file)
                rates[way].append(count / (time.perf_counter() - began))
        for way in ways:
            print(f"| {name} | {way} | {solved[way]} of {count} "
                  f"| {statistics.median(rates[way]):.3g} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)

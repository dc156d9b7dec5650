"""Prints how long ticks take beside Crocoddyl: see scripts/peers/closed_loop."""

import argparse
import csv
import json
import os
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

os.environ["OMP_NUM_THREADS"] = "1"  # before a peer is loaded
os.environ.pop("LD_PRELOAD", None)  # what it named is loaded here, and is not for our tools

import crocoddyl  # noqa: E402
import numpy as np  # noqa: E402

from conddp_tool import (BINARIES, ROOT, Untranslatable, expanded, output_of,  # noqa: E402
                         parsed, robot_settings, settings)
from crocoddyl_problem import Translation  # noqa: E402
from machine import processor  # noqa: E402

#: Of Crocoddyl, for the first plan: conddp's is solved as `conddp solve` does, too.
FIRST_PLAN = 100
#: Iterations a tick of the loops whose ends are compared.
MANY = 30
#: Ours, and its counterpart.
SOLVERS = (("fddp", "FDDP"), ("box_fddp", "BoxFDDP"))

HEAD = """# Ticks beside Crocoddyl

    scripts/peers/closed_loop

Both tools plan over the same windows of the same time line and make one iteration a tick from the shifted plan. They apply its
first controls to the same plant, the model itself, with one thread each. The first tick, which solves, is left out. Of
conddp, preparation and feedback count; of Crocoddyl, the exchange of a knot, the shift of the plan, and the iteration. A
tick's time is the shortest of several runs of the loop.

{machine}; {own}, compiled for this machine; Crocoddyl {peer}, {build}.
"""


@dataclass
class Case:
    """A file whose time line is at least as long as the last window's end."""
    file: str
    overrides: tuple
    window: int       # knots
    ticks: int


CASES = {
    "quadruped": Case("problems/quadruped_trot.yaml", ("gait.cycles=6",), 30, 100),
    "humanoid": Case("tests/foreign/talos_squat.yaml", (), 25, 24),
}


def loop_settings(case, dt, iterations, solver):
    """A loop in which everything happens at the nodes of the file."""
    loop = {"horizon": case.window * dt, "tick": dt, "duration": case.ticks * dt,
            "repeat": "none", "terminal": "none", "iterations": iterations}
    free = () if solver.startswith("box") else ("constraints={}",)
    return ("mpc=" + json.dumps(loop), f"solver.name={solver}", *free)


def our_loop(case, overrides, dt, solver, iterations):
    """Times of the ticks after the first, preparation and feedback apart, and the loop's result."""
    with tempfile.TemporaryDirectory() as folder:
        output_of([BINARIES / "conddp", "mpc", ROOT / case.file, "-o", folder,
                   *settings((*overrides, *loop_settings(case, dt, iterations, solver)))])
        with open(Path(folder) / "tick_times.csv", encoding="utf-8") as lines:
            times = [(float(row["preparation [s]"]), float(row["feedback [s]"]))
                     for row in csv.DictReader(lines)]
        with open(Path(folder) / "mpc.json", encoding="utf-8") as stream:
            outcome = json.load(stream)
    return np.array(times)[1:], outcome


class PeersLoop:
    """A loop as somebody writes it with Crocoddyl: models of the whole time line, a problem whose first
    model goes and whose next one comes, the former plan shifted."""

    def __init__(self, case, problem, solver):
        drop = () if solver.startswith("Box") else tuple(problem["constraints"])
        translation = Translation(problem, drop)
        whole = translation.shooting_problem()
        self.robot = translation.robot
        self.models, self.state = list(whole.runningModels), whole.runningModels[0].state
        actuation = self.models[0].differential.actuation
        costs = crocoddyl.CostModelSum(self.state, actuation.nu)
        free = crocoddyl.DifferentialActionModelFreeFwdDynamics(self.state, actuation, costs)
        last = crocoddyl.IntegratedActionModelEuler(free, 0)
        self.case, self.x = case, whole.x0.copy()
        self.problem = crocoddyl.ShootingProblem(self.x, self.models[:case.window], last)
        self.problem.nthreads = 1
        self.solver = getattr(crocoddyl, "Solver" + solver)(self.problem)
        self.solver.th_stop = 1e-12
        self.bounded = solver.startswith("Box")

    def first_plan(self):
        xs = [self.x] * (self.case.window + 1)
        self.solver.solve(xs, self.problem.quasiStatic(xs[:-1]), FIRST_PLAN, False)

    def advance(self, tick):
        """The plant: the model of the knot at this time."""
        model = self.models[tick]
        data = model.createData()
        u = np.array(self.solver.us[0])
        if self.bounded:
            u = np.clip(u, model.u_lb, model.u_ub)
        model.calc(data, self.x, u)
        self.x = np.array(data.xnext)

    def run(self, iterations):
        self.first_plan()
        times = []
        for tick in range(1, self.case.ticks):
            self.advance(tick - 1)
            model = self.models[tick + self.case.window - 1]
            data = model.createData()
            began = time.perf_counter()
            self.problem.circularAppend(model, data)
            self.problem.x0 = self.x
            xs, us = list(self.solver.xs), list(self.solver.us)
            xs, us = xs[1:] + xs[-1:], us[1:] + us[-1:]
            xs[0] = self.x
            self.solver.solve(xs, us, iterations, False)
            times.append(time.perf_counter() - began)
        self.advance(self.case.ticks - 1)
        return np.array(times)


def base_and_joints(robot, x):
    """Positions by our names, to compare where loops end; a base's orientation is left to its joints."""
    nq = robot.model.nq
    names = [f"base/{axis}" for axis in "xyz"] + [f"q/{joint}" for joint in robot.joints]
    return dict(zip(names, np.concatenate([x[:3], x[nq - len(robot.joints):nq]])))


def compare(name, case, robots, repeat):
    """Rows of the table, and how far the loops end from ours where each tick has many iterations."""
    overrides = (*robot_settings(case.file, robots), *case.overrides)
    problem = expanded(ROOT / case.file, overrides)
    dt = problem["phases"][0]["dt"]
    rows, apart = [], 0.0
    for ours, peers in SOLVERS:
        runs = [our_loop(case, overrides, dt, ours, 1)[0] for _ in range(repeat)]
        feedback = np.median([np.median(run[:, 1]) / np.median(run[:, 0]) for run in runs])
        own = np.min([run.sum(axis=1) for run in runs], axis=0)
        theirs = np.min([PeersLoop(case, problem, peers).run(1) for _ in range(repeat)], axis=0)
        rows.append((name, case.window, f"conddp `{ours}`", own, f"{100 * feedback:.1f} %", ""))
        rows.append((name, case.window, f"Crocoddyl Solver{peers}", theirs, "",
                     f"{np.median(theirs) / np.median(own):.1f}"))
        last = our_loop(case, overrides, dt, ours, MANY)[1]["last_state"]
        loop = PeersLoop(case, problem, peers)
        loop.run(MANY)
        found = base_and_joints(loop.robot, loop.x)
        apart = max(apart, max(abs(last[key] - found[key]) for key in found))
    return rows, apart


def table(rows):
    lines = ["| loop | knots | solver | median, ms | 95 %, ms | longest, ms | feedback, of preparation "
             "| times ours |", "|---|---:|---|---:|---:|---:|---:|---:|"]
    for name, window, solver, times, feedback, ratio in rows:
        figures = " | ".join(f"{1e3 * figure:.3g}" for figure in
                             (np.median(times), np.quantile(times, 0.95), times.max()))
        lines.append(f"| {name} | {window} | {solver} | {figures} | {feedback} | {ratio} |")
    return "\n".join(lines)


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/peers/closed_loop", description=(
        "Times the ticks of conddp mpc and of a loop over Crocoddyl, and prints a table in Markdown."))
    parser.add_argument("--case", action="append", choices=list(CASES), help="only these cases")
    parser.add_argument("--repeat", type=int, default=5,
                        help="runs of each loop; of a tick's times the shortest counts")
    return parsed(parser, "talos_reduced.urdf")


def main():
    wanted = arguments()
    rows, notes = [], []
    for name in wanted.case or CASES:
        print(f"{name} ...", file=sys.stderr)
        try:
            found, apart = compare(name, CASES[name], wanted.robots, wanted.repeat)
        except Untranslatable as refusal:
            print(f"{name}: left out: {refusal}", file=sys.stderr)
            continue
        rows += found
        notes.append(f"{name} {apart:.1e}")
    own = output_of([BINARIES / "conddp", "--version"]).splitlines()[0]
    print(HEAD.format(machine=processor(), own=own, peer=crocoddyl.__version__,
                      build="compiled for this machine" if wanted.native else "its wheel"))
    print(table(rows))
    print(f"\nWith {MANY} iterations a tick the loops of both tools end at the same positions, to (m, "
          f"rad): {', '.join(notes)}.")


main()

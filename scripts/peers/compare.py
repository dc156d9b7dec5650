"""Prints the comparison of docs/measurements/peers.md: see scripts/peers/compare."""

import argparse
import os
import sys

os.environ["OMP_NUM_THREADS"] = "1"  # before a peer is loaded
os.environ.pop("LD_PRELOAD", None)  # what it named is loaded here, and is not for our tools

import kernels  # noqa: E402
import solvers  # noqa: E402
from conddp_tool import (NATIVE, PEERS, ROOT, Untranslatable, parsed,  # noqa: E402
                         robot_settings)
from machine import processor  # noqa: E402
from table import equality_table, kernel_table, solver_table  # noqa: E402

SIXTY = "constraints.torque={bounds: control, lower: -60, upper: 60}"
#: name: (file, settings, constraints that are dropped for solvers without bounds)
CASES = {
    "HyQ trot": ("tests/foreign/hyq_trot.yaml", (), ("torque",)),
    "HyQ trot, ±60 Nm": ("tests/foreign/hyq_trot.yaml", (SIXTY,), ()),
    "HyQ trot, μ 0.15": ("tests/foreign/hyq_trot.yaml", ("contacts.defaults.friction=0.15",), ()),
    "quadruped trot": ("problems/quadruped_trot.yaml", (), ()),
    "arm reach": ("problems/arm_reach.yaml", (), ()),
    "arm reach in a second": ("problems/arm_reach.yaml", ("phases.0.knots=100",), ("torque",)),
    "Talos squat": ("tests/foreign/talos_squat.yaml", (), ("torque",)),
}

#: ProxDDP is not done there after 100 iterations, a minute.
WITHOUT_ALIGATOR = {"Talos squat"}


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/peers/compare", description=(
        "Solves the same problems with conddp, Crocoddyl and Aligator, one thread each, and "
        "prints tables in Markdown."))
    parser.add_argument("--case", action="append", choices=list(CASES), help="only these cases")
    parser.add_argument("--file", action="append", default=[], help="a problem file besides")
    parser.add_argument("--repeat", type=int, default=21, help="timed runs of each solver")
    parser.add_argument("--no-kernels", action="store_true", help="solvers alone")
    return parsed(parser, "hyq.urdf, talos_reduced.urdf, panda.urdf")


def main():
    wanted = arguments()
    cases = {name: CASES[name] for name in wanted.case or ([] if wanted.file else CASES)}
    for file in wanted.file:
        cases[os.path.basename(file)] = (os.path.abspath(file), (), ())
    results = []
    for name, (file, settings, drop) in cases.items():
        print(f"{name} ...", file=sys.stderr)
        try:
            where = robot_settings(file, wanted.robots)
            results.append(solvers.compare(name, ROOT / file, (*where, *settings), drop,
                                           wanted.repeat, name not in WITHOUT_ALIGATOR))
        except Untranslatable as refusal:
            print(f"{name}: left out: {refusal}", file=sys.stderr)
    print(f"{processor()}; {solvers.versions(wanted.native)}.\n")
    print(solver_table(results))
    print(equality_table(results))
    if not wanted.no_kernels:
        print(kernel_table(kernels.compare(wanted.robots, NATIVE if wanted.native else PEERS),
                           "compiled here" if wanted.native else "wheel"))


main()

"""Prints the comparison of docs/measurements/small_systems.md: see scripts/peers/small_systems."""

import argparse
import os
import statistics
import sys
import tempfile
import time

os.environ["OMP_NUM_THREADS"] = "1"  # before a peer is loaded

import casadi  # noqa: E402
import numpy  # noqa: E402
from casadi_problem import Program  # noqa: E402
from conddp_tool import ROOT, solve_times  # noqa: E402
from machine import processor  # noqa: E402
from figures import number  # noqa: E402

CASES = {"double integrator": "double_integrator_limits", "pendulum": "pendulum_goal",
         "cart-pole": "cartpole_goal", "acrobot": "acrobot_goal",
         "three discs": "unicycle_obstacles", "escape": "unicycle_escape"}
OURS = ("altro", "proxddp", "ipopt")
PEERS = {"fatrop": {"tol": 1e-8, "print_level": 0},
         "ipopt": {"tol": 1e-8, "print_level": 0, "sb": "yes"}}
#: Answers are one optimum if their costs differ by less.
SAME = 1e-5


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/peers/small_systems", description=(
        "Solves small systems with conddp and, by CasADi, with fatrop and Ipopt, one thread each, "
        "and prints a table in Markdown."))
    parser.add_argument("--case", action="append", choices=list(CASES), help="only these cases")
    parser.add_argument("--repeat", type=int, default=21, help="timed runs of each solver")
    parser.add_argument("--optimization", default="3", choices="0123",
                        help="the compiler's level for the peers' functions: lower for large ones")
    return parser.parse_args()


def compile_solver(name, program, level):
    """The derivatives as C, compiled for this machine."""
    options = {"print_time": False, "record_time": True, "error_on_fail": False, "jit": True,
               "compiler": "shell", "jit_options": {"flags": [f"-O{level}", "-march=native"]},
               name: PEERS[name]}
    if name == "fatrop":
        options |= {"structure_detection": "auto", "equality": program.equality}
    return casadi.nlpsol("solver", name, program.nlp(), options)


def run(solver, program, guess):
    begin = time.perf_counter()
    answer = solver(x0=guess, lbg=program.lower, ubg=program.upper)
    return answer, time.perf_counter() - begin


def peer_row(name, program, guess, repeat, level):
    solver = compile_solver(name, program, level)
    answer, _ = run(solver, program, guess)
    stats = solver.stats()
    iterations, solved = stats["iter_count"], bool(stats["success"])
    seconds = statistics.median(run(solver, program, guess)[1] for _ in range(repeat))
    return {"solver": f"CasADi's {name}", "solved": solved, "cost": float(answer["f"]), "iterations": iterations,
            "seconds": seconds}


def our_row(file, solver, repeat):
    found = solve_times(file, solver, repeat)
    runs = found["runs"]
    return found, {"solver": f"conddp `{solver}`", "solved": found["status"] == "converged",
                   "cost": found["cost"], "iterations": found["iterations"],
                   "seconds": statistics.median(one["total"] for one in runs)}


def check_program(program, found):
    """That the guess costs the same, and our answer satisfies the peers' rows and costs the same."""
    at = casadi.Function("at", [program.nlp()["x"]], [program.nlp()["f"], program.nlp()["g"]])
    cost, rows = at(program.point(found["answer"]))
    wanted = found["cost"]
    violation = program.violation(numpy.array(rows).ravel())
    if abs(float(cost) - wanted) > 1e-9 * max(1, abs(wanted)) or violation > 1e-6:
        raise RuntimeError(f"not the same problem: cost {float(cost)} and {wanted}, {violation}")


def line(name, row, ours):
    """A row of the table. Other optima are named: their times say little."""
    same = abs(row["cost"] / ours["cost"] - 1) <= SAME
    state = "not solved" if not row["solved"] else "" if same else "another optimum"
    ratio = "" if row is ours or state else number(row["seconds"] / ours["seconds"], 1, 2)
    return (f"| {name} | {row['solver']} | {row['cost']:.8g} | {row['iterations']} "
            f"| {number(row['seconds'], 1e3)} | {ratio or state} |")


def main():
    wanted = arguments()
    os.chdir(tempfile.mkdtemp())  # CasADi compiles in the working directory
    lines = ["| problem | solver | cost | iterations | ms | beside `altro` |", "|---|---|---|---|---|---|"]
    for name in wanted.case or CASES:
        print(f"{name} ...", file=sys.stderr)
        file = ROOT / "problems" / f"{CASES[name]}.yaml"
        found, ours = our_row(file, OURS[0], wanted.repeat)
        program = Program(file)
        check_program(program, found)
        guess = program.point(found["guess"])
        rows = [ours, *(our_row(file, solver, wanted.repeat)[1] for solver in OURS[1:])]
        rows += [peer_row(peer, program, guess, wanted.repeat, wanted.optimization) for peer in PEERS]
        lines += [line(name if row is ours else "", row, ours) for row in rows]
    print(f"{processor()}; CasADi {casadi.__version__}.\n")
    print("\n".join(lines))


main()

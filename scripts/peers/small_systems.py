"""Prints the comparisons of docs/measurements/small_systems.md: see scripts/peers/small_systems."""

import argparse
import math
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
         "three discs": "unicycle_obstacles", "escape": "unicycle_escape",
         "quadrotor": "quadrotor_zigzag"}
OURS = ("altro", "proxddp", "ipddp", "ipopt")
PEERS = {"fatrop": {"tol": 1e-8, "print_level": 0},
         "ipopt": {"tol": 1e-8, "print_level": 0, "sb": "yes"}}
#: Cases whose functions a compiler would digest for hours if they were written out for every knot.
CALLS = ("escape", "quadrotor")
#: Answers are one optimum if their costs differ by less.
SAME = 1e-5


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/peers/small_systems", description=(
        "Solves small systems with conddp and, by CasADi, with fatrop and Ipopt, one thread each, "
        "and prints a table in Markdown."))
    parser.add_argument("--case", action="append", choices=list(CASES), help="only these cases")
    parser.add_argument("--repeat", type=int, default=21, help="timed runs of each solver")
    parser.add_argument("--starts", type=int, default=0, metavar="N", help=(
        "a second table, from N guesses off by normal random numbers: "
        "how often, and how fast, answers are found"))
    parser.add_argument("--spread", type=float, default=0.3, help="their standard deviation")
    return parser.parse_args()


def compile_solver(name, program):
    """The derivatives as C, compiled for this machine."""
    options = {"print_time": False, "record_time": True, "error_on_fail": False, "jit": True,
               "compiler": "shell", "jit_options": {"flags": ["-O3", "-march=native"]},
               name: PEERS[name]}
    if name == "fatrop":
        options |= {"structure_detection": "auto", "equality": program.equality}
    return casadi.nlpsol("solver", name, program.nlp(), options)


def run(solver, program, guess):
    begin = time.perf_counter()
    answer = solver(x0=guess, lbg=program.lower, ubg=program.upper)
    return answer, time.perf_counter() - begin


def peer_row(name, solver, program, guess, repeat):
    answer, _ = run(solver, program, guess)
    stats = solver.stats()
    iterations, solved = stats["iter_count"], bool(stats["success"])
    seconds = statistics.median(run(solver, program, guess)[1] for _ in range(repeat))
    return {"solver": f"CasADi's {name}", "solved": solved, "cost": float(answer["f"]), "iterations": iterations,
            "seconds": seconds}


def our_row(file, solver, repeat, overrides=()):
    found = solve_times(file, solver, repeat, overrides)
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


def rows_from(file, program, solvers, repeat, overrides=()):
    """Every solver's row from one guess, `altro` first."""
    found, ours = our_row(file, OURS[0], repeat, overrides)
    if ours["solved"]:
        check_program(program, found)
    guess = program.point(found["guess"])
    rows = [ours, *(our_row(file, solver, repeat, overrides)[1] for solver in OURS[1:])]
    return rows + [peer_row(name, solver, program, guess, repeat) for name, solver in solvers.items()]


def same(row, other):
    return abs(row["cost"] / other["cost"] - 1) <= SAME


def lines_of_guess(name, rows):
    """Of the table from the problems' own guesses. Other optima are named: their times say little."""
    ours = rows[0]
    for row in rows:
        state = "not solved" if not row["solved"] else "" if same(row, ours) else "another optimum"
        ratio = "" if row is ours or state else number(row["seconds"] / ours["seconds"], 1, 2)
        yield (f"| {name if row is ours else ''} | {row['solver']} | {row['cost']:.8g} | {row['iterations']} "
               f"| {number(row['seconds'], 1e3)} | {ratio or state} |")


def lines_of_starts(name, starts):
    """Of the table from many guesses: a line for each solver. Times are compared where both solve."""
    best = [min((row["cost"] for row in rows if row["solved"]), default=math.nan) for rows in starts]
    for i, first in enumerate(starts[0]):
        column = [rows[i] for rows in starts]
        solved = [row for row in column if row["solved"]]
        at_best = sum(row["solved"] and row["cost"] <= cost + SAME * abs(cost)
                      for row, cost in zip(column, best))
        middle = {key: statistics.median(row[key] for row in solved) if solved else math.nan
                  for key in ("iterations", "seconds")}
        ratios = [row["seconds"] / rows[0]["seconds"] for row, rows in zip(column, starts)
                  if row["solved"] and rows[0]["solved"] and same(row, rows[0])]
        beside = f"{number(statistics.geometric_mean(ratios), 1, 2)} ({len(ratios)})" if i and ratios else ""
        yield (f"| {'' if i else name} | {first['solver']} | {len(solved)} | {at_best} "
               f"| {number(middle['iterations'])} | {number(middle['seconds'], 1e3)} | {beside} |")


HEADER_OF_GUESS = ("| problem | solver | cost | iterations | ms | beside `altro` |", "|---|---|---|---|---|---|")
HEADER_OF_STARTS = ("| problem | solver | solved | as the best | iterations | ms | beside `altro` (starts) |",
                    "|---|---|---|---|---|---|---|")


def main():
    wanted = arguments()
    os.chdir(tempfile.mkdtemp())  # CasADi compiles in the working directory
    tables = [list(HEADER_OF_GUESS), list(HEADER_OF_STARTS)]
    for name in wanted.case or CASES:
        print(f"{name} ...", file=sys.stderr)
        file = ROOT / "problems" / f"{CASES[name]}.yaml"
        program = Program(file, calls=name in CALLS)
        solvers = {peer: compile_solver(peer, program) for peer in PEERS}
        tables[0] += lines_of_guess(name, rows_from(file, program, solvers, wanted.repeat))
        starts = [rows_from(file, program, solvers, wanted.repeat,
                            (f"perturbation.guess={wanted.spread}", f"perturbation.seed={seed}"))
                  for seed in range(1, wanted.starts + 1)]
        if starts:
            tables[1] += lines_of_starts(name, starts)
    print(f"{processor()}; CasADi {casadi.__version__}.\n")
    print("\n\n".join("\n".join(table) for table in tables[:2 if wanted.starts else 1]))


main()

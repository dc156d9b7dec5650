"""Looks for false verdicts on random problems: see scripts/peers/composed_verdicts.

What counts as false, each found by Ipopt through CasADi:
- false minimum: of a certified minimum, a feasible point beside it costs less by more than 10^-6 of
  the sizes of all costs, and smaller and smaller boxes about the answer hold their part of that, so
  that it is reached by descent. A lower point beside it without such a way is another minimum;
- local_minimum, stationary as allowed: the same, by no more than the 10^-5 of the costs of which
  the certificate makes nothing;
- unresolved local_minimum, stationary: the same, by less than the resolution that it states;
- false stationary: a stationary answer with such a point, along a slope: the part falls as the
  boxes do;
- false infeasible: the half square of the violation falls by 2 % or more in the same way, or the
  log has a feasible iterate. Where a feasible point is found elsewhere, that is counted apart;
- not feasible: a converged answer that violates a row by more than its tolerance, or has gaps;
- guess lost: from a feasible motion, the end violates a row or costs more by 10^-6;
- own answer lost: from the answer as guess, a certified minimum has no verdict, or costs more;
- refuted without descent: the certificate contradicts a converged answer, and no lower point is
  found beside it, by 10^-9 of the sizes of all costs;
- twins differ: the two problems are not the same. Defect: exit status 3.
"""

import argparse
import collections
import json
import math
import os
import pathlib
import sys
import tempfile

os.environ["OMP_NUM_THREADS"] = "1"  # before CasADi is loaded

import casadi  # noqa: E402
from composed_claims import claims  # noqa: E402
from composed_judge import SAME, Judge, Problem, verdict_of  # noqa: E402
from composed_problem import Composer  # noqa: E402
from composed_program import Program  # noqa: E402
from conddp_tool import BINARIES  # noqa: E402
from machine import processor  # noqa: E402

FOUND = (
    "twins differ",
    "defect",
    "false minimum",
    "local_minimum as allowed",
    "stationary as allowed",
    "unresolved local_minimum",
    "unresolved stationary",
    "false stationary",
    "false infeasible",
    "not feasible",
    "guess lost",
    "own answer lost",
    "refuted without descent",
    "another minimum lower",
    "infeasible, feasible elsewhere",
)


def again(problem, tool, solution, judge):
    """From its own answer."""
    first = problem.folder / "first.json"
    (problem.folder / "out/solution.json").rename(first)
    second = problem.solve(tool, "--warm-start", first)
    cost = second.get("cost")
    above = math.inf if cost is None else (cost - solution["cost"]) / judge.size
    judge.record["again"] = [second["status"], verdict_of(second), above]
    return ["own answer lost"] if verdict_of(second) != "local_minimum" or above > SAME else []


def judged_seed(seed, tool, folder):
    """The record of a seed."""
    composer = Composer(seed, lambda document, u: Program(document).simulated(u))
    problem = Problem(composer.document, folder, composer.kind, composer.guess, seed)
    solution = problem.solve(tool)
    record = {
        "seed": seed,
        "kind": problem.kind,
        "solver": problem.document["solver"]["name"],
        "status": solution["status"],
        "verdict": verdict_of(solution),
        "message": solution["message"][:200],
        "found": [],
    }
    if "trajectory" not in solution:
        return record | ({"found": ["defect"]} if solution["exit"] not in (1, 2) else {})
    judge = Judge(problem, solution)
    record["found"] = judge.judged()
    if seed % 3 == 0 and record["verdict"] == "local_minimum":
        record["found"] += again(problem, tool, solution, judge)
    return (
        record
        | judge.record
        | {
            "iterations": solution["iterations"],
            "second_order": solution.get("certificate", {}).get("second_order"),
        }
    )


def table(rows, header):
    return "\n".join(
        [f"| {' | '.join(header)} |", "|---" * len(header) + "|"]
        + [f"| {' | '.join(map(str, row))} |" for row in rows]
    )


def print_tables(records):
    kinds = sorted({record["kind"] for record in records})
    endings = collections.Counter((record["status"], record["verdict"]) for record in records)
    by_kind = collections.Counter(
        (record["status"], record["verdict"], record["kind"]) for record in records
    )
    print(f"{processor()}; CasADi {casadi.__version__}; {len(records)} problems.\n")
    print(
        table(
            [
                [*ending, count, *(by_kind[(*ending, kind)] for kind in kinds)]
                for ending, count in endings.most_common()
            ],
            ["status", "verdict", "all", *kinds],
        )
        + "\n"
    )
    solvers = sorted({record["solver"] for record in records})
    counts = collections.Counter(
        (name, record["solver"]) for record in records for name in record["found"]
    )
    rows = [[name, *(counts[(name, solver)] for solver in solvers)] for name in FOUND]
    print(table([[name, sum(row), *row] for name, *row in rows], ["found", "all", *solvers]))


def self_test():
    """That the judge contradicts false claims and leaves true ones alone; else exit status 1."""
    with tempfile.TemporaryDirectory() as folder:
        results = [
            (name, expected, Judge(Problem(document, folder, guess=guess), claim).judged())
            for name, document, guess, claim, expected in claims()
        ]
    for name, expected, found in results:
        kind = "as expected" if found == expected else "WRONG"
        print(f"{kind}: {name}: {', '.join(found) or 'nothing'}")
    sys.exit(any(found != expected for _, expected, found in results))


def main():
    parser = argparse.ArgumentParser(
        prog="scripts/peers/composed_verdicts",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--first", type=int, default=0, metavar="SEED")
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--records", help="a file to which each record is appended, a line of JSON")
    parser.add_argument("--keep", help="a folder for problems of which something is found")
    parser.add_argument("--self-test", action="store_true")
    wanted = parser.parse_args()
    if wanted.self_test:
        self_test()
    records = []
    for seed in range(wanted.first, wanted.first + wanted.count):
        with tempfile.TemporaryDirectory() as folder:
            records.append(judged_seed(seed, BINARIES / "conddp", folder))
            report(records[-1], folder, wanted)
    print_tables(records)


def report(record, folder, wanted):
    if wanted.records:
        with open(wanted.records, "a", encoding="utf-8") as lines:
            lines.write(json.dumps(record) + "\n")
    if record["found"]:
        found = ", ".join(record["found"])
        print(f"{record['seed']}: {found}: {json.dumps(record)}", file=sys.stderr, flush=True)
        if wanted.keep:
            target = pathlib.Path(wanted.keep, str(record["seed"]))
            target.mkdir(parents=True, exist_ok=True)
            for name in ("problem.yaml", "guess.csv"):
                if (file := pathlib.Path(folder, name)).exists():
                    (target / name).write_bytes(file.read_bytes())


if __name__ == "__main__":
    main()

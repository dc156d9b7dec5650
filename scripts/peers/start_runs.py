"""Solves one start with every tool, each as its users do, and keeps what came out.

A record is one line of JSON: the tool, a key of all that the answer depends on, and figures of the
answer. A record with the same key is not computed again.
"""

import hashlib
import json
import subprocess
import time
from functools import cache
from importlib.metadata import version
from pathlib import Path

import crocoddyl
import numpy as np

# After Crocoddyl, which must find its own Pinocchio before it sees Aligator's.
import aligator_bridge

import conddp_tool
from conddp_tool import BINARIES, ROOT
from crocoddyl_problem import Translation
from start_check import VERSION, bounds, check

MOST_ITERATIONS = 500
MOST_SECONDS = 300
SOLVER = f"solver={{name: box_fddp, max_iterations: {MOST_ITERATIONS}}}"  # replaces the file's
#: Crocoddyl's own test of convergence, of the expected decrease of the cost by a regularised step.
#: With the default of its Box solvers, 5e-5, or with 1e-7 it stops before the check accepts some
#: answers; 1e-10 and 1e-12 solve as many starts as this.
STOP = 1e-9
#: Aligator's penalty at the start. Of 15 starts off by 0.3 it solves 10 with this and with 1e-7, 7
#: with 1e-4; of 11 off by 0.1 all with this and with 1e-4, 4 with its default, 1e-2. In these
#: trials its outer loop had its default of at most 100 iterations.
MU_INIT = 1e-6
#: Aligator's tolerance, its default. A method of multipliers ends that far from active bounds, on
#: either side: such controls are put on their bound before the check, which takes 1e-9.
TOLERANCE = 1e-6
TOOLS = ("conddp", "crocoddyl", "aligator")
HERE = Path(__file__).resolve().parent
RESULTS = conddp_tool.PEERS / "starts.jsonl"


def digest(*parts):
    total = hashlib.sha256()
    for part in parts:
        total.update(part if isinstance(part, bytes) else str(part).encode())
        total.update(b"\0")
    return total.hexdigest()[:16]


@cache
def contents(*paths):
    return digest(*(Path(path).read_bytes() for path in paths))


def files_of(instance, where):
    """The problem file and its robot."""
    urdf = next((word.split("=", 1)[1] for word in where if word.startswith("robot.urdf=")), None)
    if urdf is None:
        lines = (ROOT / instance.file).read_text(encoding="utf-8").splitlines()
        line = next(line for line in lines if "urdf:" in line)
        urdf = (ROOT / instance.file).parent / line.split("urdf:")[1].split(",")[0].strip(" }")
    return contents(ROOT / instance.file, urdf)


def key_of(tool, instance, where):
    start = (instance.file, instance.overrides, instance.state, instance.guess, instance.seed)
    common = (files_of(instance, where), *start, MOST_ITERATIONS, VERSION)
    if tool == "conddp":
        return digest(contents(BINARIES / "bench_solve_times"), SOLVER, *common)
    translation = [HERE / name for name in ("crocoddyl_problem.py", "references.py", "robot.py")]
    if tool == "crocoddyl":
        return digest(crocoddyl.__version__, STOP, contents(*translation), *common)
    return digest(crocoddyl.__version__, version("libaligator"), MU_INIT, TOLERANCE,
                  contents(*translation, HERE / "aligator_bridge.cpp"), *common)


def load(path=RESULTS):
    """Records by (tool, key); the last one wins."""
    found = {}
    if path.exists():
        for line in path.read_text(encoding="utf-8").splitlines():
            try:
                record = json.loads(line)
            except json.JSONDecodeError:  # of a run that was stopped while it wrote
                continue
            found[record["tool"], record["key"]] = record
    return found


def bench_words(instance, where, extra=()):
    """The arguments of bench_solve_times."""
    return [instance.file, "--solver", "box_fddp", "--repeat", "1", "--warm-up", "0",
            *conddp_tool.settings((*where, *instance.overrides, instance.perturbation, SOLVER,
                                   *extra))]


def tool_words(instance, where):
    """The arguments of conddp for the same solve."""
    return ["solve", instance.file, "--perturb", f"initial_state={instance.state:g}",
            "--perturb", f"guess={instance.guess:g}", "--seed", str(instance.seed),
            *conddp_tool.settings((*where, *instance.overrides, SOLVER))]


def bench(instance, where, extra=()):
    return subprocess.run([BINARIES / "bench_solve_times", *bench_words(instance, where, extra)],
                          cwd=ROOT, capture_output=True, text=True, timeout=MOST_SECONDS)


@cache
def shooting_problem(file, settings):
    """Of a problem at its unperturbed initial state. Guesses make no difference to it."""
    return Translation(conddp_tool.expanded(ROOT / file, settings)).shooting_problem()


def run_conddp(instance, where):
    """What our tool says, with its output; the output is None where there is none."""
    began = time.perf_counter()
    try:
        process = bench(instance, where)
    except subprocess.TimeoutExpired:
        return {"status": "timeout", "message": f"{MOST_SECONDS} s"}, None
    if process.returncode != 0:
        return {"status": "error", "message": process.stderr.strip()[-300:]}, None
    out = json.loads(process.stdout)
    return {"status": out["status"], "message": out["message"], "iterations": out["iterations"],
            "claimed": out["status"] == "converged", "claimed_cost": out["cost"],
            "seconds": out["runs"][0]["total"], "process_seconds": time.perf_counter() - began}, out


def vectors(guess):
    return [crocoddyl.StdVec_VectorXs([np.array(row) for row in guess[part]]) for part in "xu"]


def run_crocoddyl(problem, guess):
    solver = crocoddyl.SolverBoxFDDP(problem)
    solver.th_stop = STOP
    start = vectors(guess)
    began = time.perf_counter()
    converged = solver.solve(*start, MOST_ITERATIONS, False)
    return {"status": "converged" if converged else "not converged", "claimed": bool(converged),
            "claimed_cost": float(solver.cost), "iterations": solver.iter + 1,
            "seconds": time.perf_counter() - began,
            "check": check(problem, list(solver.xs), list(solver.us))}


def on_bounds(model, u):
    """The control with entries that are within Aligator's tolerance of a bound put there."""
    lower, upper = bounds(model)
    u = np.where(u <= lower + TOLERANCE, lower, u)
    return np.where(u >= upper - TOLERANCE, upper, u)


def run_aligator(problem, guess):
    try:
        converged, iterations, (seconds,), xs, us = aligator_bridge.solve(
            problem, *vectors(guess), TOLERANCE, MU_INIT, MOST_ITERATIONS, 1)
    except RuntimeError as error:  # factorisations that fail
        return {"status": "error", "message": str(error)[-300:]}
    us = [on_bounds(model, u) for model, u in zip(problem.runningModels, us)]
    return {"status": "converged" if converged else "not converged", "claimed": converged,
            "iterations": iterations, "seconds": seconds, "check": check(problem, list(xs), us)}


def fingerprint(guess):
    """A few numbers that tell guesses apart."""
    rows = np.concatenate([np.concatenate(guess["x"]), np.concatenate(guess["u"])])
    return [float(rows @ np.cos(factor * np.arange(len(rows)))) for factor in (1.0, 2.0)]


def is_same_guess(first, second):
    return np.allclose(first, second, rtol=1e-6, atol=1e-6)


def run(task):
    """The records of a start that are missing: task = (instance, where, tools, what is known)."""
    instance, where, tools, known = task
    records = []
    keys = {tool: key_of(tool, instance, where) for tool in tools}
    problem = shooting_problem(instance.file, (*where, *instance.settings))

    def keep(tool, record):
        records.append({"tool": tool, "key": keys[tool], "row": instance.row, "name": instance.name,
                        **record})

    out = None
    if "conddp" not in known:
        record, out = run_conddp(instance, where)
        if out is not None:
            guess = out["guess"]
            problem.x0 = np.array(guess["x"][0])
            inside = [np.clip(u, *bounds(model))  # conddp begins there
                      for model, u in zip(problem.runningModels, guess["u"])]
            at_guess = problem.calc([np.array(x) for x in guess["x"]], inside)
            record["check"] = check(problem, out["answer"]["x"], out["answer"]["u"])
            record["guess"] = fingerprint(guess)
            record["guess_costs"] = [out["runs"][0]["log"][0]["cost"], float(at_guess)]
        keep("conddp", record)
    guess = out["guess"] if out is not None else None
    for tool, solve in (("crocoddyl", run_crocoddyl), ("aligator", run_aligator)):
        theirs = known.get(tool)
        if tool not in tools or theirs is not None and (
                out is None or is_same_guess(theirs["guess"], fingerprint(guess))):
            continue  # else the start may not be the one that it solved
        guess = guess or json.loads(
            bench(instance, where, ("solver.max_iterations=1",)).stdout)["guess"]
        problem.x0 = np.array(guess["x"][0])
        keep(tool, {**solve(problem, guess), "guess": fingerprint(guess)})
    return records

"""A composed problem, what conddp says of it, and what Ipopt finds against that."""

import json
import math
import pathlib
import random
import subprocess

import numpy
from composed_program import Program
from composed_search import Neighbourhood, feasible_point

#: As shares of the sizes of all costs; of the violation's half square.
SAME, NONE, ALLOWED, FALLS = 1e-6, 1e-9, 1e-5, 0.02
#: The tolerances of the file.
CONSTRAINT, GAP, ROUNDING = 1e-6, 1e-9, 1e-11


class Problem:
    """A document, and a feasible motion as its guess where it has one, in a folder of its own."""

    def __init__(self, document, folder, kind="", guess=None, seed=0):
        self.document, self.kind, self.guess = document, kind, None
        self.folder, self.program = pathlib.Path(folder), Program(document)
        self.draw = random.Random(seed)
        if guess:
            self.guess = self.program.point(*guess)
            self._write_guess(*guess)
        self.path = self.folder / "problem.yaml"
        self.path.write_text(json.dumps(self.document, indent=1), encoding="utf-8")

    def _write_guess(self, x, u):
        """The motion, whose last control has no knot."""
        header = ["t", *self.program.states, *self.program.controls]
        rows = [[k * self.program.dt, *a, *b] for k, (a, b) in enumerate(zip(x, [*u, u[-1]]))]
        text = "\n".join(",".join(map(repr, row)) for row in rows)
        (self.folder / "guess.csv").write_text(f"{','.join(header)}\n{text}\n", encoding="utf-8")
        self.document["initial_guess"] = {
            part: {"file": "guess.csv"} for part in ("states", "controls")
        }

    def solve(self, tool, *options):
        out, words = self.folder / "out", "--max-time 20 --threads 1 --quiet -o".split()
        command = [tool, "solve", self.path, *words, out, *options]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        file = out / "solution.json"
        if run.returncode == 2 or not file.exists():
            message = run.stderr.strip()[:300]
            return {"status": "refused", "message": message, "exit": run.returncode}
        return json.loads(file.read_text(encoding="utf-8")) | {"exit": run.returncode}

    def default_guess(self):
        """Rest, where no other guess is: the start of searches."""
        n = self.program.knots
        return self.program.point(
            [self.program.start] * (n + 1), [[0] * len(self.program.controls)] * n
        )


def verdict_of(solution):
    return solution.get("certificate", {}).get("verdict", "none")


class Judge:
    """What Ipopt finds against an answer."""

    def __init__(self, problem, solution):
        self.problem, self.program, self.solution = problem, problem.program, solution
        trajectory = solution["trajectory"]
        finite = all(
            value is not None for key in ("x", "u") for row in trajectory[key] for value in row
        )
        self.z = self.program.point(trajectory["x"], trajectory["u"]) if finite else None
        self.record = {}

    def judged(self):
        """The names of what is found; figures are in the record."""
        if self.z is None:
            return []
        self.near = Neighbourhood(self.program)
        self.parts, self.gap, self.distances = self.program.at(self.z)
        self.size = self.near.size(self.z)
        cost = self.solution["cost"]
        self.record |= {
            "cost": cost,
            "gap": self.gap,
            "violation": float(numpy.max(self.distances)),
        }
        if cost is not None and abs(math.fsum(self.parts) - cost) > 1e-9 * self.size:
            return ["twins differ"]
        found = ["defect"] if self.solution["exit"] == 3 else []
        status = self.solution["status"]
        if status == "converged":
            found += self._converged()
        elif status == "infeasible":
            found += self._infeasible()
        return found + self._of_guess()

    def _converged(self):
        found = []
        gap = 1.01 * GAP + ROUNDING * float(numpy.max(numpy.abs(self.z)))
        if self.record["violation"] > 1.01 * CONSTRAINT or self.gap > gap:
            found.append("not feasible")
        verdict = verdict_of(self.solution)
        refuted = verdict in ("not_a_minimum", "contradicted")
        gain, reached, lower = self.near.descends(
            self.z, self.problem.draw, NONE if refuted else SAME
        )
        self.record |= {
            "gain": gain,
            "size": self.size,
            "lower": math.fsum(self.program.at(lower)[0]),
        }
        if refuted:
            return found + self._refuted(gain)
        if gain <= SAME:
            return found
        if not reached:
            return found + ["another minimum lower"]
        nothing = self.solution["certificate"].get("second_order", {}).get("resolution") or 0
        if gain * self.size <= nothing:
            return [*found, f"unresolved {verdict}"]
        ranges = self.program.ranges(self.z)
        self.record["far"] = self.near.lowest(self.z, 0.5, [(lower - self.z) / ranges / 0.5])[0]
        if self.record["far"] <= ALLOWED:
            return [*found, f"{verdict} as allowed"]
        if verdict == "local_minimum":
            return [*found, "false minimum"]
        slope = self.near.lowest(self.z, 5e-4, [(lower - self.z) / ranges / 0.1])[0]
        return [*found, "false stationary"] if slope > 1e-3 * gain else found

    def _refuted(self, gain):
        """Rightly so where the cost falls, or rises where rows are met to the last digit."""
        if gain > NONE:
            return []
        rise = -self.near.lowest(self.z, 0.05, [0 * self.z], -math.inf)[0]
        self.record["rise"] = rise
        return ["refuted without descent"] if rise <= SAME else []

    def _infeasible(self):
        near = Neighbourhood(self.program, of_violation=True)
        gain, reached, _ = near.descends(self.z, self.problem.draw, FALLS, (1, 0.1, 0.01))
        self.record["gain"] = gain
        in_log = any(
            None not in (row["gap"], row["constraint"])
            and row["gap"] <= GAP
            and row["constraint"] <= CONSTRAINT
            for row in self.solution["log"]
        )
        if (reached and gain > FALLS) or in_log:
            self.record["in_log"] = in_log
            return ["false infeasible"]
        draw, ranges = self.problem.draw, self.program.ranges(self.z)
        starts = [self.z, self.problem.default_guess()]
        starts += [
            self.z + spread * ranges * [draw.uniform(-1, 1) for _ in self.z]
            for spread in (0.1, 1, 3)
        ]
        elsewhere = (
            self.problem.guess is not None or feasible_point(self.program, starts) is not None
        )
        return ["infeasible, feasible elsewhere"] if elsewhere else []

    def _of_guess(self):
        guess = self.problem.guess
        if guess is None:
            return []
        above = math.fsum(self.parts) - math.fsum(self.program.at(guess)[0])
        self.record["above_guess"] = above / max(self.size, self.near.size(guess))
        return (
            ["guess lost"]
            if self.record["above_guess"] > SAME
            or self.record["violation"] > 1.01 * CONSTRAINT
            or self.solution["status"] == "infeasible"
            else []
        )

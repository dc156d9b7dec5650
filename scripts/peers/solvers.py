"""One problem, solved by every solver of the comparison."""

import statistics
import time
from dataclasses import dataclass, field
from importlib.metadata import version

import crocoddyl
import numpy as np
import pinocchio

# After Crocoddyl, which must find its own Pinocchio before it sees Aligator's.
import aligator_bridge

import conddp_tool
from crocoddyl_problem import Translation

TOLERANCE = 1e-9          # of the cost, relative, and of the gaps
EQUALITY = 1e-6           # of costs between the tools, relative
WARM_UP = 3
MOST_ITERATIONS = 300
MOST_OF_ALIGATOR = 100
NEVER = 1e-300               # a tolerance that stops nothing
MU_INIT = (1e-2, 1e-4, 1e-6)


@dataclass
class Row:
    """What is known of one solver on one problem; times in seconds."""
    solver: str
    dropped: bool                      # without the bounds of the controls
    guess_cost: float = np.nan
    guess_gap: float = np.nan
    best_cost: float = np.nan          # the lowest that it reaches
    parts: tuple = ()                  # differentiate, sweep, rollout with a full step: each once
    iteration: float = np.nan          # of a whole solve
    iterations: int | None = None      # to the tolerance
    to_tolerance: float = np.nan
    whole: float = np.nan              # with the solver's own test of convergence
    whole_iterations: int | None = None
    converged: bool = False

    @property
    def step(self):
        return sum(self.parts) if self.parts else np.nan


@dataclass
class Comparison:
    name: str
    knots: int
    rows: list = field(default_factory=list)
    optimum: dict = field(default_factory=dict)  # by whether bounds were dropped


def versions(native):
    both = f"Crocoddyl {crocoddyl.__version__} and Pinocchio {pinocchio.__version__}"
    aligator = f"Aligator {version('libaligator')}"
    wheels = "of the Python index (generic x86-64)"
    if native:
        return (f"{both} compiled for this machine like conddp, {aligator} as the wheel {wheels} "
                "with Crocoddyl's models as compiled here")
    return f"{both} and {aligator} as wheels {wheels}, conddp compiled for this machine"


def vectors(rows):
    return crocoddyl.StdVec_VectorXs([np.array(row) for row in rows])


def evaluate(problem, xs, us):
    """Cost and largest gap of a trajectory: one function for all peers."""
    cost = problem.calc(xs, us)
    gaps = [np.abs(model.state.diff(after, data.xnext)).max() for model, data, after
            in zip(problem.runningModels, problem.runningDatas, list(xs)[1:])]
    first = np.abs(problem.runningModels[0].state.diff(xs[0], problem.x0)).max()
    return cost, max(first, *gaps)


def violation(problem, us):
    return max(max((model.u_lb - u).max(), (u - model.u_ub).max(), 0.0)
               for model, u in zip(problem.runningModels, us))


def reached(cost, gap, optimum):
    return cost - optimum <= TOLERANCE * abs(optimum) and gap <= TOLERANCE


def median(values):
    return statistics.median(list(values))


class Conddp:
    """One of our solvers, through bench_solve_times."""

    def __init__(self, solver, file, settings, drop):
        self.solver, self.file, self.settings, self.drop = solver, file, settings, drop

    def run(self, repeat, stationarity, iterations=MOST_ITERATIONS):
        settings = (*self.settings, f"solver.tolerances.stationarity={stationarity}",
                    f"solver.max_iterations={iterations}")
        return conddp_tool.solve_times(self.file, self.solver, repeat, settings, self.drop)

    def best(self):
        self.tight = self.run(1, 1e-10)
        last = self.tight["runs"][0]["log"][-1]
        return last["cost"] if last["gap"] <= TOLERANCE else np.inf

    def measure(self, optimum, repeat):
        row = Row(f"conddp `{self.solver}`", bool(self.drop))
        start = self.tight["runs"][0]["log"][0]
        row.guess_cost, row.guess_gap = start["cost"], start["gap"]
        row.best_cost = min(r["cost"] for r in self.tight["runs"][0]["log"]
                            if r["gap"] <= TOLERANCE)
        row.iterations = next((k for k, r in enumerate(self.tight["runs"][0]["log"])
                               if reached(r["cost"], r["gap"], optimum)), None)
        if row.iterations is not None:
            timed = self.run(repeat, 1e-12, row.iterations)
            # Our log looks at the derivatives of an iterate first; peers end with its rollout.
            logged = median(run["log"][row.iterations]["time"] for run in timed["runs"])
            row.to_tolerance = logged - timed["evaluator"]["differentiate"]
        whole = self.run(repeat, 1e-6)
        row.whole = median(run["total"] for run in whole["runs"])
        row.whole_iterations, row.converged = whole["iterations"], whole["status"] == "converged"
        row.iteration = row.whole / row.whole_iterations
        row.parts = tuple(whole["evaluator"][part] for part in ("differentiate", "sweep", "rollout"))
        return row


class Crocoddyl:
    def __init__(self, solver, problem, guess, dropped):
        self.name, self.problem, self.guess, self.dropped = solver, problem, guess, dropped

    def fresh(self, stop=None):
        solver = getattr(crocoddyl, "Solver" + self.name)(self.problem)
        if stop is not None:
            solver.th_stop = stop
        return solver

    def timed(self, solver, iterations):
        began = time.perf_counter()
        converged = solver.solve(*self.guess, iterations, False)
        return time.perf_counter() - began, converged

    def best(self):
        solver = self.fresh(1e-12)
        history = self.history = []

        class Watch(crocoddyl.CallbackAbstract):
            def __call__(self, watched):
                history.append(watched.cost)

        solver.setCallbacks([Watch()])
        solver.solve(*self.guess, MOST_ITERATIONS, False)
        cost, gap = evaluate(self.problem, solver.xs, solver.us)
        self.answer = cost if gap <= TOLERANCE else np.inf
        return self.answer

    def first_iteration(self, optimum):
        """Iterations until cost and gap are there, checked on the trajectory itself."""
        start = next((k for k, cost in enumerate(self.history, 1)
                      if reached(cost, 0, optimum)), None)
        if start is None:
            return None
        for iterations in range(start, len(self.history) + 1):
            solver = self.fresh(NEVER)
            self.timed(solver, iterations)
            if reached(*evaluate(self.problem, solver.xs, solver.us), optimum):
                return iterations
        return None

    def measure(self, optimum, repeat):
        row = Row(f"Crocoddyl {self.name}", self.dropped)
        row.guess_cost, row.guess_gap = evaluate(self.problem, *self.guess)
        row.best_cost = self.answer
        row.iterations = self.first_iteration(optimum)
        if row.iterations is not None:
            solver = self.fresh(NEVER)
            times = [self.timed(solver, row.iterations)[0] for _ in range(WARM_UP + repeat)]
            row.to_tolerance = median(times[WARM_UP:])
        solver = self.fresh()
        runs = [self.timed(solver, MOST_ITERATIONS) for _ in range(WARM_UP + repeat)]
        row.whole = median(took for took, _ in runs[WARM_UP:])
        row.whole_iterations, row.converged = solver.iter + 1, runs[-1][1]
        row.iteration = row.whole / row.whole_iterations
        row.parts = self.parts(max(repeat, 50))
        return row

    def parts(self, repeat):
        """Derivatives, sweep and one rollout with a full step, at the optimum."""
        solver, samples = self.fresh(1e-9), []
        self.timed(solver, MOST_ITERATIONS)
        for _ in range(WARM_UP + repeat):
            self.problem.calc(solver.xs, solver.us)  # where a solve comes from its last rollout
            began = time.perf_counter()
            solver.calcDiff()
            differentiated = time.perf_counter()
            solver.backwardPass()
            swept = time.perf_counter()
            solver.forwardPass(1.0)
            ended = time.perf_counter()
            samples.append((differentiated - began, swept - differentiated, ended - swept))
        return tuple(median(column) for column in zip(*samples[WARM_UP:]))


class Aligator:
    """ProxDDP with a linear rollout; of its options only mu_init is tuned, the best is shown."""

    def __init__(self, problem, guess, mu):
        self.problem, self.guess, self.mu = problem, guess, mu

    def run(self, tolerance, iterations, repeat):
        converged, count, seconds, xs, us = aligator_bridge.solve(
            self.problem, *self.guess, tolerance, self.mu, iterations, repeat)
        cost, gap = evaluate(self.problem, xs, us)
        good = violation(self.problem, us) <= EQUALITY
        return converged, count, list(seconds), cost, gap if good else np.inf

    def best(self):
        _, self.count, _, cost, gap = self.run(1e-6, MOST_OF_ALIGATOR, 1)
        self.answer = cost if gap <= EQUALITY else np.inf
        return np.inf  # to its own tolerance alone: no yardstick

    def first_iteration(self, optimum):
        for k, (xs, us) in enumerate(aligator_bridge.iterates(
                self.problem, *self.guess, 1e-12, self.mu, self.count + 20), 1):
            cost, gap = evaluate(self.problem, xs, us)
            # Bounds may still be exceeded, hence a cost below the optimum.
            if abs(cost - optimum) <= TOLERANCE * abs(optimum) and gap <= TOLERANCE:
                return k
        return None

    def measure(self, optimum, repeat):
        row = Row(f"Aligator ProxDDP, mu_init {self.mu:g}", False)
        row.guess_cost, row.guess_gap = evaluate(self.problem, *self.guess)
        row.best_cost = self.answer
        row.iterations = self.first_iteration(optimum)
        if row.iterations is not None:
            row.to_tolerance = median(
                self.run(1e-12, row.iterations, WARM_UP + repeat)[2][WARM_UP:])
        row.converged, row.whole_iterations, seconds, _, _ = self.run(
            1e-6, MOST_OF_ALIGATOR, WARM_UP + repeat)
        row.whole = median(seconds[WARM_UP:])
        row.iteration = row.whole / row.whole_iterations
        return row


def best_aligator(problem, guess):
    """Of the starting penalties the one with which it converges in the fewest iterations."""
    trials = []
    for mu in MU_INIT:
        trial = Aligator(problem, guess, mu)
        converged, count, *_ = trial.run(1e-6, MOST_OF_ALIGATOR, 1)
        trials.append((not converged, count, mu, trial))
    return min(trials, key=lambda entry: entry[:3])[3]


def compare(name, file, settings, drop, repeat, with_aligator):
    specification = conddp_tool.expanded(file, settings)
    problem = Translation(specification).shooting_problem()
    ours = Conddp("box_fddp", file, settings, ())
    first = ours.run(1, 1e-6)
    guess = vectors(first["guess"]["x"]), vectors(first["guess"]["u"])
    contenders = {False: [ours, Crocoddyl("BoxFDDP", problem, guess, False)]}
    if with_aligator:
        contenders[False].append(best_aligator(problem, guess))
    if drop:
        free = Translation(specification, drop).shooting_problem()
        contenders[True] = [Conddp("fddp", file, settings, drop),
                            Crocoddyl("FDDP", free, guess, True)]
    comparison = Comparison(name, first["knots"])
    for dropped, group in contenders.items():
        optimum = min(contender.best() for contender in group)
        comparison.optimum[dropped] = optimum
        comparison.rows += [contender.measure(optimum, repeat) for contender in group]
    return comparison

"""Trajectory optimization of robots under constraints, with certified answers.

    import conddp
    problem = conddp.load("reach.yaml")
    problem["terminal.costs.hand.reference.position"] = [0.3, 0.4, 0.5]
    answer = problem.solve()
    print(answer.status, answer.cost, answer.verdict)
    answer.x, answer.u, answer.K        # NumPy arrays, node by node

Files and keys are those of the tool `conddp`.
"""

import json
import math
import os
import threading
from typing import (
    Any,
    Callable,
    Dict,
    Iterable,
    List,
    Mapping,
    Optional,
    Sequence,
    Tuple,
    Union,
    overload,
)

import numpy

from . import _core
from ._dataset import Dataset, read_dataset
from ._errors import ProblemError
from ._exports import write_mcap, write_rerun
from ._extras import needed
from .mjcf import from_mjcf

__all__ = [
    "Answer",
    "Dataset",
    "Mpc",
    "Problem",
    "ProblemError",
    "from_mjcf",
    "load",
    "problem",
    "read_dataset",
]

_Path = Union[str, "os.PathLike[str]"]


def _yaml(value: Any) -> str:
    """A value as YAML on one line; arrays are lists."""
    if isinstance(value, numpy.ndarray):
        value = value.tolist()
    if isinstance(value, numpy.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else (".inf" if value > 0 else "-.inf")
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(str(k))}: {_yaml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_yaml(v) for v in value) + "]"
    if value is None or isinstance(value, (bool, int, float, str)):
        return json.dumps(value)
    if isinstance(value, os.PathLike):
        return json.dumps(os.fspath(value))
    raise TypeError(f"a value of a problem cannot be of type {type(value).__name__}")


def _names(text: str) -> Dict[str, Any]:
    """The columns of x and u at the top."""
    names = json.loads(text)
    return {**names.pop("columns"), **names}


def _settings(values: Mapping[str, Any]) -> Dict[str, str]:
    return {key: _yaml(value) for key, value in values.items()}


class Answer:
    """An answer with any status: the last iterate and what is known about it. solve() makes it.

    Arrays are views of the answer's memory and cannot be written.
    """

    def __init__(self, core: "_core.Answer"):
        self._core = core
        self._names: Optional[Dict[str, Any]] = None

    @property
    def status(self) -> str:
        """'converged', 'max_iterations', 'infeasible', 'time_limit', ... as in solution.json."""
        return self._core.status

    @property
    def solved(self) -> bool:
        """True if the solve ended well and its certificate does not deny it."""
        return self._core.solved

    @property
    def verdict(self) -> str:
        """Of the certificate: 'local_minimum', 'stationary', ...; '' without a certificate."""
        return self._core.verdict

    @property
    def message(self) -> str:
        """One sentence about how the solve ended."""
        return self._core.message

    @property
    def solver(self) -> str:
        """The solver that found the answer."""
        return self._core.solver

    @property
    def cost(self) -> float:
        """Sum of all costs, without a unit."""
        return self._core.cost

    @property
    def iterations(self) -> int:
        """Iterations of that solver."""
        return self._core.iterations

    @property
    def seconds(self) -> float:
        """Time of all solves, s."""
        return self._core.seconds

    @property
    def t(self) -> numpy.ndarray:
        """Times of the nodes, s: N + 1 numbers."""
        return self._core.t

    @property
    def x(self) -> numpy.ndarray:
        """States, (N + 1) x nx; columns as in names['x'], units as in names['units']['x']."""
        return self._core.x

    @property
    def u(self) -> Union[numpy.ndarray, List[numpy.ndarray]]:
        """Controls, N x nu, columns as in names['u']; a list of arrays if phases differ in them."""
        return self._core.u

    @property
    def K(self) -> List[numpy.ndarray]:
        """Feedback gains of each knot, nu x ndx: u = u_k + K_k (x - x_k), in the tangent space."""
        return self._core.K

    @property
    def names(self) -> Dict[str, Any]:
        """Names of the columns of x and u, their units, and the phases."""
        if self._names is None:
            self._names = _names(self._core.names())
        return self._names

    @property
    def document(self) -> Dict[str, Any]:
        """The content of solution.json."""
        content: Dict[str, Any] = json.loads(self._core.document())
        return content

    @property
    def certificate(self) -> Optional[Dict[str, Any]]:
        """The certificate: verdict, checks with claimed and found figures; None without one."""
        content: Optional[Dict[str, Any]] = json.loads(self._core.certificate())
        return content

    @overload
    def report(self) -> str: ...
    @overload
    def report(self, file: _Path) -> None: ...
    def report(self, file: Optional[_Path] = None) -> Optional[str]:
        """The page with the motion and its curves: written to a file, or returned as HTML."""
        page = self._core.page()
        if file is None:
            return page
        with open(file, "w", encoding="utf-8") as out:
            out.write(page)
        return None

    def save(
        self,
        folder: _Path,
        report: bool = False,
        formats: Sequence[str] = ("json", "csv"),
    ) -> List[str]:
        """Writes solution.json, trajectory.csv and iterations.csv, all or none; returns paths.

        formats: 'json', 'csv' and 'npz' (trajectory.npz, for numpy.load).
        """
        return self._core.write(os.fspath(folder), report, ",".join(formats))

    def to_frame(self) -> Any:
        """States and controls as a pandas.DataFrame, indexed by time; the last node has no u."""
        pandas = needed("pandas", "frames", "to_frame()")
        if isinstance(self.u, list):
            raise ValueError("controls differ between phases: take answer.x and answer.u")
        controls = numpy.vstack([self.u, numpy.full((1, self.u.shape[1]), numpy.nan)])
        columns = ["x/" + name for name in self.names["x"]] + ["u/" + n for n in self.names["u"]]
        return pandas.DataFrame(
            numpy.hstack([self.x, controls]), index=pandas.Index(self.t, name="t"), columns=columns
        )

    def to_mcap(self, file: _Path, start: float = 0.0) -> None:
        """Writes the motion as MCAP with messages of ROS 2, for Foxglove and others.

        /joint_states (JointState) and /joint_trajectory (JointTrajectory) have the joints, /tf a
        free base, /robot_description the URDF, and topics of their own all numbers of x and u
        (Float64). The first node is at `start`, s since 1970. Needs the package mcap-ros2-support.
        """
        write_mcap(self, os.fspath(file), start)

    def to_rerun(self, file: _Path) -> None:
        """Writes a recording for Rerun (.rrd): curves of x and u, and the bodies with their shapes.

        Poses are those of the report, rounded to 1e-6 m. Needs the package rerun-sdk.
        """
        write_rerun(self, os.fspath(file))

    def _repr_html_(self) -> str:
        import html

        return (
            f'<iframe srcdoc="{html.escape(self._core.page())}" width="100%" height="600" '
            'style="border: 0"></iframe>'
        )

    def __repr__(self) -> str:
        return (
            f"<conddp.Answer {self.status} ({self.solver}, {self.iterations} iterations), "
            f"cost {self.cost:.9g}, {self.verdict or 'not verified'}>"
        )


class Problem:
    """A problem with settings of its keys: problem["costs.effort.weight"] = 0.1.

    load() and problem() make it.

    Robots are read once; a solve builds the rest anew, so that every key may be set. Copies share
    what was read. Threads may share a problem: a solve takes the keys that are set when it begins.
    """

    def __init__(self, core: "_core.Problem"):
        self._core = core
        self._lock = threading.Lock()  # check() and describe() read the settings without the GIL

    def __setitem__(self, key: str, value: Any) -> None:
        """Sets a key by its path, as --set does: numbers, strings, lists, dicts, arrays."""
        text = _yaml(value)
        with self._lock:
            self._core.set(key, text)

    def __getitem__(self, key: str) -> Any:
        """The value of a key as set, or in the file. Raises KeyError if neither has it."""
        try:
            return json.loads(self._core.get(key))
        except IndexError:
            raise KeyError(key) from None

    def update(self, values: Mapping[str, Any]) -> None:
        """Sets several keys."""
        for key, value in values.items():
            self[key] = value

    def copy(self) -> "Problem":
        """The same problem, with settings of its own."""
        return Problem(self._core.copy())

    def check(self) -> List[str]:
        """Builds the problem; returns warnings and notes. Errors raise ProblemError."""
        with self._lock:
            return self._core.check()

    @property
    def names(self) -> Dict[str, Any]:
        """Names of the columns of x and u, their units, the phases, the name, the number of knots."""
        with self._lock:
            return _names(self._core.describe())

    def solve(
        self,
        solver: Optional[str] = None,
        *,
        warm_start: Optional[Answer] = None,
        guess: Optional[Tuple[numpy.ndarray, Sequence[numpy.ndarray]]] = None,
        verify: bool = True,
        on_iteration: Optional[Callable[[Dict[str, float]], None]] = None,
        **settings: Any,
    ) -> Answer:
        """Solves the problem as `conddp solve` does, and returns its answer.

        solver: in place of the file's, 'auto' included.
        warm_start: an answer to start from, multipliers included if shapes agree.
        guess: states (N + 1 rows) and controls (N rows) to start from.
        verify: False leaves out the certificate.
        on_iteration: called with a dictionary of figures; an exception ends the solve.
        settings: further keys of `solver` for this solve, such as max_iterations=50.

        Ctrl-C raises KeyboardInterrupt. Other threads run meanwhile.
        """
        own = {"solver." + key: value for key, value in settings.items()}
        if solver is not None:
            own["solver.name"] = solver
        if warm_start is not None and guess is not None:
            raise ValueError("give either warm_start or guess")
        if guess is not None:
            states, controls = guess
            guess = (
                numpy.ascontiguousarray(states, dtype=float),
                [numpy.ascontiguousarray(row, dtype=float) for row in controls],
            )
        former = warm_start._core if warm_start is not None else None
        return Answer(self._core.solve(_settings(own), former, guess, verify, on_iteration))

    def solve_many(
        self, settings: Iterable[Mapping[str, Any]], jobs: Optional[int] = None, verify: bool = True
    ) -> List[Answer]:
        """Solves the problem with each of these settings; returns the answers in their order.

        Each is solved in one thread, as in a batch: `auto` ends at the first answer that is
        certified. jobs: how many at a time; by default as many as there are processors.
        """
        jobs = jobs or len(os.sched_getaffinity(0))
        if jobs < 1:
            raise ValueError("jobs must be at least 1")
        many = [_settings(own) for own in settings]
        return [Answer(core) for core in self._core.solve_many(many, jobs, verify)]


class Mpc:
    """Model predictive control by the section `mpc` of a problem, for a plant of your own.

    In a loop at any rate: u = loop.tick(t, x). A plan is made where a tick of the file is due; in
    between, the plan in force and its gains give the control. Threads that share a loop take turns.
    """

    def __init__(self, problem: Problem):
        self._core = _core.Loop(problem._core)
        self._lock = threading.Lock()  # a plan is made without the GIL

    def tick(self, t: float, x: numpy.ndarray) -> numpy.ndarray:
        """The control (nu) at a time (s) and a measured state (nx). Times must not decrease."""
        with self._lock:
            return self._core.tick(t, x)

    def prepare(self) -> None:
        """Does the part of the next plan that needs no measurement, in idle time."""
        with self._lock:
            self._core.prepare()

    @property
    def period(self) -> float:
        """Time between two plans, s."""
        return self._core.period

    @property
    def last(self) -> Dict[str, Any]:
        """Figures of the last plan: tick, time_s, outcome, iterations, cost, violation, fallback."""
        with self._lock:
            return self._core.last


def load(file: _Path) -> Problem:
    """Reads a problem file. Raises ProblemError with the place of each error."""
    return Problem(_core.Problem(os.fspath(file)))


def problem(content: Union[str, Mapping[str, Any]], folder: _Path = ".") -> Problem:
    """A problem from YAML text or a dictionary of its keys; relative paths begin at `folder`."""
    text = content if isinstance(content, str) else _yaml(content)
    return Problem(_core.Problem(text, os.fspath(folder)))

"""The package as its users see it: answers of the tool, errors with places, threads."""

import json
import pathlib
import signal
import subprocess
import sys
import textwrap
import threading
import time

import numpy
import pytest

import conddp

PROBLEMS = pathlib.Path(__file__).parents[2] / "problems"

MASS = """conddp: 1
name: mass
system: {states: {x: m, v: m/s}, controls: {force: N}, rate: {x: v, v: force}}
initial_state: {values: {x: 0}}
phases: [{name: go, knots: 20, dt: 0.05}]
costs: {effort: {residual: control, weight: 0.1}}
constraints: {limits: {bounds: control, lower: -8, upper: 8}}
terminal: {constraints: {there: {residual: state, reference: [1, 0]}}}
solver: {name: altro}
"""


@pytest.fixture
def mass():
    return conddp.problem(MASS)


def test_answer_has_arrays_of_its_motion(mass):
    answer = mass.solve()
    assert (answer.status, answer.verdict, answer.solved) == ("converged", "local_minimum", True)
    assert answer.x.shape == (21, 2) and answer.u.shape == (20, 1) and len(answer.K) == 20
    assert answer.K[0].shape == (1, 2)
    numpy.testing.assert_allclose(answer.t, numpy.linspace(0, 1, 21), atol=1e-12)
    numpy.testing.assert_allclose(answer.x[-1], [1, 0], atol=1e-6)
    # Symplectic Euler's steps: the velocity moves first.
    velocity = answer.x[:-1, 1] + 0.05 * answer.u[:, 0]
    numpy.testing.assert_allclose(answer.x[1:, 1], velocity, atol=1e-9)
    assert answer.cost == pytest.approx(0.1 * 0.5 * 0.05 * numpy.sum(answer.u**2))
    with pytest.raises(ValueError):
        answer.x[0, 0] = 1


def test_arrays_outlive_their_answer(mass):
    x = mass.solve().x
    assert x[-1, 0] == pytest.approx(1, abs=1e-6)


def test_answer_is_that_of_the_tool(tmp_path):
    answer = conddp.load(PROBLEMS / "arm_reach.yaml").solve()
    answer.save(tmp_path)
    document = json.loads((tmp_path / "solution.json").read_text())
    assert document["certificate"]["verdict"] == answer.verdict
    assert document["cost"] == answer.cost
    assert numpy.array_equal(numpy.array(document["trajectory"]["x"]), answer.x)
    assert answer.document["status"] == "converged"
    assert answer.names["x"] == document["trajectory"]["columns"]["x"]


def test_keys_are_set_and_read(mass):
    assert mass["phases.go.knots"] == 20
    mass["phases.go.knots"] = 10
    mass["terminal.constraints.there.reference"] = numpy.array([0.5, 0])
    assert mass["phases.go.knots"] == 10
    answer = mass.solve()
    assert answer.x.shape[0] == 11
    numpy.testing.assert_allclose(answer.x[-1], [0.5, 0], atol=1e-6)
    with pytest.raises(KeyError):
        mass["costs.friction"]


def test_copies_have_settings_of_their_own(mass):
    other = mass.copy()
    other["phases.go.knots"] = 5
    assert mass["phases.go.knots"] == 20


def test_dictionaries_are_problems():
    problem = conddp.problem(
        {
            "conddp": 1,
            "name": "mass",
            "system": {"states": ["x"], "controls": ["u"], "rate": {"x": "u"}},
            "initial_state": {"values": {"x": 0.0}},
            "phases": [{"name": "go", "knots": 4, "dt": 0.25}],
            "costs": {"effort": {"residual": "control"}},
            "terminal": {"costs": {"goal": {"residual": "state", "reference": [1], "weight": 1e3}}},
        }
    )
    assert problem.solve().x[-1, 0] == pytest.approx(1, abs=1e-2)


def test_errors_name_their_place(mass):
    mass["costs.effort.wieght"] = 2
    with pytest.raises(conddp.ProblemError) as caught:
        mass.solve()
    assert "wieght" in str(caught.value) and "weight" in str(caught.value)
    assert caught.value.errors[0]["key"].startswith("costs.effort")
    with pytest.raises(conddp.ProblemError, match="nowhere.yaml"):
        conddp.load("nowhere.yaml")
    with pytest.raises(conddp.ProblemError, match=":3:1: error"):
        conddp.problem("conddp: 1\nname: [\n")
    with pytest.raises(TypeError):
        mass["costs.effort.weight"] = object()


@pytest.mark.parametrize(
    "key, value",
    [
        ("costs.effort.weight", float("nan")),
        ("costs.effort.weight", float("inf")),
        ("initial_state.values.x", float("nan")),
        ("terminal.constraints.there.reference", numpy.array([numpy.nan, 0])),
        ("terminal.constraints.there.reference", numpy.zeros(3)),
        ("terminal.constraints.there.reference", numpy.zeros((2, 2))),
        ("constraints.limits.lower", [-8, -8]),
        ("phases.go.knots", 2.5),
        ("phases.go.knots", numpy.array([])),
    ],
)
def test_nan_and_wrong_shapes_are_errors(mass, key, value):
    with pytest.raises(conddp.ProblemError) as caught:
        mass[key] = value
        mass.solve()
    assert caught.value.errors[0]["message"]


def test_unknown_solver_is_an_error(mass):
    with pytest.raises(conddp.ProblemError, match="solvers: auto"):
        mass.solve("newton")


def test_npz_has_the_arrays(tmp_path):
    answer = conddp.load(PROBLEMS / "quadruped_trot.yaml").solve(verify=False)
    assert answer.save(tmp_path, formats=["npz"]) == [str(tmp_path / "trajectory.npz")]
    with numpy.load(tmp_path / "trajectory.npz") as stored:
        assert list(stored["x_names"]) == answer.names["x"]
        assert list(stored["u_units"]) == answer.names["units"]["u"]
        for name in ("t", "x", "u"):
            assert numpy.array_equal(stored[name], getattr(answer, name))
        assert numpy.array_equal(stored["K"], numpy.stack(answer.K))
        assert stored["costates"].shape == (len(answer.t), stored["K"].shape[2])
        forces = answer.document["trajectory"]["contact_forces"]
        for name, rows in forces.items():
            held = numpy.array([row is not None for row in rows])
            force = stored["contact/" + name]
            assert numpy.isnan(force[~held]).all() and held.any()
            assert numpy.array_equal(force[held][:, :3], numpy.array([r for r in rows if r]))
    with pytest.raises(ValueError, match="formats"):
        answer.save(tmp_path, formats=["hdf5"])


def test_warm_starts_save_iterations(mass):
    cold = mass.solve("ipopt")
    warm = mass.solve("ipopt", warm_start=cold)
    assert warm.iterations < cold.iterations
    assert warm.cost == pytest.approx(cold.cost)
    mass["phases.go.knots"] = 40
    assert mass.solve(warm_start=cold).solved


def test_warm_starts_of_other_systems_are_refused(mass):
    other = conddp.load(PROBLEMS / "arm_reach.yaml")
    with pytest.raises(ValueError, match="other states"):
        other.solve(warm_start=mass.solve())


def test_guesses_are_checked(mass):
    states, controls = numpy.zeros((21, 2)), numpy.zeros((20, 1))
    assert mass.solve(guess=(states, controls)).solved
    for guess in [
        (states[:-1], controls),
        (states[:, :1], controls),
        (states, controls[:-1]),
        (states + numpy.nan, controls),
        (states, controls + numpy.inf),
        (states, numpy.zeros((20, 2))),
    ]:
        with pytest.raises(ValueError, match="guess"):
            mass.solve(guess=guess)
    with pytest.raises(ValueError):
        mass.solve(guess=([["x", "v"]] * 21, controls))
    with pytest.raises(ValueError, match="either"):
        mass.solve(guess=(states, controls), warm_start=mass.solve())


def test_iterations_are_reported(mass):
    rows = []
    answer = mass.solve(on_iteration=rows.append)
    assert len(rows) >= answer.iterations and rows[-1]["stationarity"] >= 0

    def stop(row):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        mass.solve(on_iteration=stop)


def test_many_are_solved_in_order(mass):
    goals = [0.2, 0.4, 0.6, 0.8]
    answers = mass.solve_many(
        [{"terminal.constraints.there.reference": [goal, 0]} for goal in goals], jobs=2
    )
    assert [round(answer.x[-1, 0], 4) for answer in answers] == goals
    one = mass.solve_many([{"terminal.constraints.there.reference": [0.6, 0]}])[0]
    assert numpy.array_equal(one.x, answers[2].x)
    with pytest.raises(conddp.ProblemError):
        mass.solve_many([{}, {"costs.effort.wieght": 1}])
    assert mass.solve_many([]) == []
    with pytest.raises(ValueError, match="jobs"):
        mass.solve_many([{}], jobs=-1)


def test_threads_share_a_problem(mass):
    answers = [None] * 4

    def work(i):
        answers[i] = mass.solve("ipopt" if i % 2 else "altro")

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(answer.solved for answer in answers)
    assert numpy.array_equal(answers[0].x, answers[2].x)


def test_keys_may_be_set_during_solves(mass):
    goal, done = "terminal.constraints.there.reference", threading.Event()
    mass[goal] = [0.2, 0]

    def turn():
        while not done.is_set():
            for place in (0.2, 0.8):
                mass[goal] = [place, 0]

    thread = threading.Thread(target=turn)
    thread.start()
    try:
        ends = [mass.solve().x[-1, 0] for _ in range(30)]
        assert mass.check() is not None and mass.names["knots"] == 20
    finally:
        done.set()
        thread.join()
    assert all(min(abs(end - 0.2), abs(end - 0.8)) < 1e-6 for end in ends)


SOLVE_ON = """
def tell(row):
    print("on", flush=True)
while True:
    problem.solve("ipopt", on_iteration=tell)
"""
#: Minutes of work.
SOLVE_MANY = """
print("on", flush=True)
problem.solve_many([{"solver.name": "ipopt"}] * 2000, jobs=2)
"""


@pytest.mark.parametrize("work", [SOLVE_ON, SOLVE_MANY], ids=["solve", "solve_many"])
def test_interrupt_ends_solves(work):
    code = f"""
import conddp, sys
problem = conddp.problem({MASS!r})
problem["phases.go.knots"] = 2000
try:
{textwrap.indent(work, "    ")}
except KeyboardInterrupt:
    sys.exit(7)
"""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        try:
            process.communicate(timeout=30)
        except subprocess.TimeoutExpired:
            process.kill()
        assert process.returncode == 7


def test_loops_control_a_plant(mass):
    mass["costs.goal"] = {"residual": "state", "reference": [1, 0], "weight": 100}
    mass["mpc"] = {"horizon": 0.5, "tick": 0.05, "duration": 3.0}
    loop = conddp.Mpc(mass)
    x, dt = numpy.zeros(2), 0.01
    for k in range(300):
        u = loop.tick(k * dt, x)
        x = x + dt * numpy.array([x[1], u[0]])
    assert loop.last["outcome"] == "planned"
    assert abs(x[0] - 1) < 0.01
    with pytest.raises(ValueError, match="decrease"):
        loop.tick(0.0, x)
    with pytest.raises(ValueError, match="finite"):
        loop.tick(4.0, x + numpy.nan)
    with pytest.raises(ValueError, match="2 numbers"):
        loop.tick(4.0, numpy.zeros(3))


def test_threads_take_turns_in_a_loop(mass):
    mass["mpc"] = {"horizon": 0.5, "tick": 0.05, "duration": 100}
    loop = conddp.Mpc(mass)
    told = []

    def work():
        for k in range(500):
            try:
                told.append(float(loop.tick(k * 0.01, numpy.zeros(2))[0]))
            except ValueError as error:  # another thread is ahead
                assert "decrease" in str(error)
            loop.prepare()

    threads = [threading.Thread(target=work) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(told) >= 500 and numpy.isfinite(told).all()
    assert loop.last["tick"] == 99


def test_a_loop_needs_its_section(mass):
    with pytest.raises(conddp.ProblemError, match="mpc"):
        conddp.Mpc(mass)


def test_reports_are_pages(mass, tmp_path):
    answer = mass.solve()
    answer.report(tmp_path / "mass.html")
    assert "<html" in (tmp_path / "mass.html").read_text()[:200].lower()
    assert answer._repr_html_().startswith("<iframe")


@pytest.mark.parametrize(
    "package, extra, call",
    [
        ("h5py", "dataset", lambda answer: conddp.read_dataset("dataset.h5")),
        ("pandas", "frames", lambda answer: answer.to_frame()),
        ("mcap_ros2.writer", "mcap", lambda answer: answer.to_mcap("mass.mcap")),
        ("mujoco", "mujoco", lambda answer: conddp.from_mjcf("robot.xml")),
        ("rerun", "rerun", lambda answer: answer.to_rerun("mass.rrd")),
    ],
)
def test_missing_packages_name_their_extra(mass, monkeypatch, package, extra, call):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(ImportError, match=rf"pip install 'conddp\[{extra}\]'"):
        call(mass.solve(verify=False))

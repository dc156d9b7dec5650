"""Files for other programs, read back: data sets of batches, MCAP, Rerun."""

import pathlib
import shutil
import subprocess

import numpy
import pytest

conddp = pytest.importorskip("conddp")

ROOT = pathlib.Path(__file__).parents[2]
PLAN = """conddp_batch: 1
problem: {problem}
vary:
  goal: {{key: terminal.costs.tool.reference.position.0, linspace: [0.35, 0.5, 3]}}
  knots: {{key: phases.reach.knots, values: [20, 35]}}
  rule: {{key: integrator, values: [semi_implicit_euler]}}
"""
GOAL = "terminal.costs.tool.reference.position.0"


@pytest.fixture(scope="module")
def reaches(tmp_path_factory):
    """The data set of six reaches, three of them shorter."""
    pytest.importorskip("h5py")
    folder = tmp_path_factory.mktemp("batch")
    (folder / "plan.yaml").write_text(PLAN.format(problem=ROOT / "problems/arm_reach.yaml"))
    built = ROOT / "build/release/bin/conddp"
    tool = built if built.exists() else shutil.which("conddp")
    run = [tool, "batch", "run", "plan.yaml", "-o", "run", "-j", "1"]
    subprocess.run(run, cwd=folder, check=True, capture_output=True)
    return conddp.read_dataset(folder / "run" / "dataset.h5")


def test_dataset_has_the_answers(reaches):
    problem = conddp.load(ROOT / "problems/arm_reach.yaml")
    settings = [
        {GOAL: goal, "phases.reach.knots": n} for goal in (0.35, 0.425, 0.5) for n in (20, 35)
    ]
    answers = problem.solve_many(settings, jobs=1)
    x, u, K = reaches["x"], reaches["u"], reaches["K"]
    assert x.shape == (6, 36, 14) and u.shape == (6, 35, 7) and K.shape == (6, 35, 7, 14)
    assert reaches.lengths.tolist() == [21, 36] * 3
    for i, answer in enumerate(answers):
        n = len(answer.u)
        assert numpy.array_equal(x[i, : n + 1], answer.x)
        assert numpy.array_equal(u[i, :n], answer.u)
        assert numpy.array_equal(K[i, :n], answer.K)
        assert numpy.isnan(x[i, n + 1 :]).all() and numpy.isnan(u[i, n:]).all()
        assert reaches["cost"][i] == answer.cost
    assert reaches.columns["x"] == answers[0].names["x"]
    assert reaches.units["u"] == answers[0].names["units"]["u"]


def test_dataset_has_settings_as_columns(reaches):
    assert len(reaches) == 6 and reaches["item"].tolist() == [1, 2, 3, 4, 5, 6]
    numpy.testing.assert_allclose(reaches.parameters["goal"], [0.35, 0.35, 0.425, 0.425, 0.5, 0.5])
    assert reaches.parameters["knots"].tolist() == [20, 35] * 3
    assert numpy.isnan(reaches.parameters["rule"]).all()
    assert reaches.keys_of_parameters["goal"] == GOAL
    assert set(reaches["status"]) == {"converged"} and reaches["problem"][0].endswith(
        "arm_reach.yaml"
    )
    pytest.importorskip("pandas")
    frame = reaches.to_frame()
    assert frame.loc[5, "goal"] == 0.5 and frame.loc[5, "cost"] == reaches["cost"][4]


def test_dataset_splits_by_shapes(reaches):
    short, long = reaches.shapes
    assert short["x"].shape == (3, 21, 14) and long["item"].tolist() == [2, 4, 6]
    assert not numpy.isnan(short["x"]).any()


def test_unknown_arrays_are_errors(reaches):
    assert "x" in reaches and "y" not in reaches
    assert {"x", "u", "K", "t", "cost", "parameters"} < set(reaches.arrays)
    with pytest.raises(KeyError, match="costates"):
        reaches["y"]


def test_other_columns_are_errors(reaches, tmp_path):
    h5py = pytest.importorskip("h5py")
    file = tmp_path / "mixed.h5"
    shutil.copy(reaches._file, file)
    with h5py.File(file, "a") as content:
        names = content["shape_2"]["x"].attrs["columns"]
        names[0] = "q/elbow"
        content["shape_2"]["x"].attrs["columns"] = names
    mixed = conddp.read_dataset(file)
    with pytest.raises(ValueError, match="other columns"):
        mixed["x"]
    assert mixed["u"].shape == (6, 35, 7) and mixed.shapes[1].columns["x"][0].endswith("elbow")


def test_other_files_are_no_datasets(tmp_path):
    h5py = pytest.importorskip("h5py")
    h5py.File(tmp_path / "other.h5", "w").close()
    with pytest.raises(ValueError, match="no data set"):
        conddp.read_dataset(tmp_path / "other.h5")
    with pytest.raises(FileNotFoundError):
        conddp.read_dataset(tmp_path / "missing.h5")


@pytest.fixture(scope="module")
def trot():
    return conddp.load(ROOT / "problems/quadruped_trot.yaml").solve(verify=False)


def messages(file):
    """Messages and times, s, by topic."""
    reader = pytest.importorskip("mcap_ros2.reader")
    found = {}
    for message in reader.read_ros2_messages(str(file)):
        found.setdefault(message.channel.topic, []).append(
            (message.log_time_ns * 1e-9, message.ros_msg)
        )
    return found


def test_mcap_has_joints_and_base(trot, tmp_path):
    pytest.importorskip("mcap_ros2")
    trot.to_mcap(tmp_path / "trot.mcap", start=100)
    found = messages(tmp_path / "trot.mcap")
    names = [name[2:] for name in trot.names["x"][7:19]]
    times = [time for time, _ in found["/joint_states"]]
    numpy.testing.assert_allclose(times, 100 + trot.t, atol=1e-8)
    for k, (time, state) in enumerate(found["/joint_states"]):
        assert list(state.name) == names
        assert list(state.position) == trot.x[k, 7:19].tolist()
        assert list(state.velocity) == trot.x[k, 25:].tolist()
        assert list(state.effort) == (trot.u[k].tolist() if k < 64 else [])
        assert state.header.stamp.sec + 1e-9 * state.header.stamp.nanosec == pytest.approx(time)
    ((_, whole),) = found["/joint_trajectory"]
    assert list(whole.joint_names) == names and len(whole.points) == 65
    last = whole.points[-1]
    assert list(last.positions) == trot.x[-1, 7:19].tolist()
    reached = last.time_from_start.sec + 1e-9 * last.time_from_start.nanosec
    assert reached == pytest.approx(trot.t[-1], abs=1e-8)
    for k, (_, message) in enumerate(found["/tf"]):
        (base,) = message.transforms
        at, turn = base.transform.translation, base.transform.rotation
        pose = [at.x, at.y, at.z, turn.x, turn.y, turn.z, turn.w]
        assert pose == trot.x[k, :7].tolist()
    assert (base.header.frame_id, base.child_frame_id) == ("world", "trunk")
    assert "<robot" in found["/robot_description"][0][1].data


def test_mcap_has_every_number(tmp_path):
    pytest.importorskip("mcap_ros2")
    answer = conddp.load(ROOT / "problems/cartpole_swingup_closed_form.yaml").solve(verify=False)
    answer.to_mcap(tmp_path / "cart.mcap")
    found = messages(tmp_path / "cart.mcap")
    assert sorted(found) == ["/u/force", "/x/omega", "/x/theta", "/x/vx", "/x/x"]
    assert [message.data for _, message in found["/x/theta"]] == answer.x[:, 1].tolist()
    assert [message.data for _, message in found["/u/force"]] == answer.u[:, 0].tolist()


def recorded(file):
    """Columns of a recording by entity and component; times, s, beside them."""
    chunk = pytest.importorskip("rerun.chunk")
    found = {}
    for one in chunk.RrdReader(str(file)).stream().to_chunks():
        batch = one.to_record_batch()
        columns = {name: batch.column(name).to_pylist() for name in batch.schema.names}
        found.setdefault(str(one.entity_path), {}).update(columns)
    return found


def test_rerun_has_curves_and_bodies(trot, tmp_path):
    pytest.importorskip("rerun")
    trot.to_rerun(tmp_path / "trot.rrd")
    found = recorded(tmp_path / "trot.rrd")
    for i, name in enumerate(trot.names["x"]):
        own = found["/x/" + name.removeprefix("x/")]
        numpy.testing.assert_array_equal(numpy.ravel(own["Scalars:scalars"]), trot.x[:, i])
    control = found["/" + trot.names["u"][3]]
    numpy.testing.assert_array_equal(numpy.ravel(control["Scalars:scalars"]), trot.u[:, 3])
    times = [time.total_seconds() for time in found["/x/base/x"]["t"]]
    numpy.testing.assert_allclose(times, trot.t, atol=1e-6)
    base = found["/scene/base"]
    poses = numpy.array(base["Transform3D:translation"]).reshape(-1, 3)
    numpy.testing.assert_allclose(poses, trot.x[:, :3], atol=1e-6)
    turns = numpy.array(base["Transform3D:quaternion"]).reshape(-1, 4)
    numpy.testing.assert_allclose(turns, trot.x[:, 3:7], atol=1e-6)
    assert "Boxes3D:half_sizes" in found["/scene/base/trunk_0"]
    assert "Cylinders3D:lengths" in found["/scene/LF_KFE/LF_shank_0"]


def test_rerun_draws_meshes(tmp_path):
    pytest.importorskip("rerun")
    (tmp_path / "tile.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n")
    (tmp_path / "tile.urdf").write_text("""<robot name="tile"><link name="world"/><link name="tile">
        <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
        <visual><geometry><mesh filename="tile.obj" scale="1 1 1"/></geometry></visual></link>
        <joint name="slide" type="prismatic"><parent link="world"/><child link="tile"/><axis xyz="1 0 0"/>
        <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>""")
    answer = conddp.problem(
        {
            "conddp": 1,
            "name": "tile",
            "robot": {"urdf": "tile.urdf"},
            "initial_state": {},
            "phases": [{"name": "go", "knots": 4, "dt": 0.1}],
            "costs": {"effort": {"residual": "control"}},
        },
        tmp_path,
    ).solve()
    answer.to_rerun(tmp_path / "tile.rrd")
    own = recorded(tmp_path / "tile.rrd")["/scene/slide/tile_0_0"]
    corners = numpy.array(own["Mesh3D:vertex_positions"]).reshape(-1, 3)
    numpy.testing.assert_allclose(
        sorted(map(tuple, corners)), [(0, 0, 0), (0, 2, 0), (1, 0, 0)], atol=1e-4
    )

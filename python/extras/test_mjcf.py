"""Robots of MJCF files against MuJoCo: inertia matrix and bias forces of the written URDF, by Pinocchio.

    pip install mujoco pin gymnasium dm_control && pip install --no-deps robosuite && pytest python/extras
"""

import importlib.util
import pathlib
from xml.etree import ElementTree

import numpy
import pytest

mujoco = pytest.importorskip("mujoco")
pinocchio = pytest.importorskip("pinocchio")
conddp = pytest.importorskip("conddp")

FOLDERS = {
    "dm_control": ["suite", "mujoco/testing/assets", "locomotion/walkers/assets", "third_party"],
    "gymnasium": ["envs/mujoco/assets"],
    "robosuite": ["models/assets/robots"],
}


def files():
    found = []
    for package, folders in FOLDERS.items():
        spec = importlib.util.find_spec(package)
        for folder in folders if spec else []:
            found += sorted((pathlib.Path(spec.origin).parent / folder).rglob("*.xml"))
    return found


def state_of(model, names, data):
    """q and v of Pinocchio's model for those of MuJoCo, and the order of MuJoCo's velocities."""
    q, v, order = pinocchio.neutral(model), numpy.zeros(model.nv), []
    for name in model.names[1:]:
        joint = model.joints[model.getJointId(name)]
        if name == "root_joint":
            rotation = numpy.zeros(9)
            mujoco.mju_quat2Mat(rotation, data.qpos[3:7])
            rotation = rotation.reshape(3, 3)
            q[:3], q[3:6], q[6] = data.qpos[:3], data.qpos[4:7], data.qpos[3]
            v[:3], v[3:6] = rotation.T @ data.qvel[:3], data.qvel[3:6]
            order += range(6)
            continue
        index = names[name]
        angle = data.qpos[index[0]] - index[2]
        if joint.nq == 2:
            q[joint.idx_q : joint.idx_q + 2] = numpy.cos(angle), numpy.sin(angle)
        else:
            q[joint.idx_q] = angle
        v[joint.idx_v] = data.qvel[index[1]]
        order.append(index[1])
    return q, v, order


@pytest.mark.parametrize("file", files(), ids=lambda file: f"{file.parent.name}/{file.stem}")
def test_dynamics(file, tmp_path):
    try:
        source = mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        pytest.skip(str(error))
    if source.nv == 0:
        pytest.skip("no joints")
    try:
        robot = conddp.from_mjcf(file, tmp_path)
    except ValueError as error:
        pytest.skip(str(error))
    floating = robot["base"] == "floating"
    model = (
        pinocchio.buildModelFromUrdf(robot["urdf"], pinocchio.JointModelFreeFlyer())
        if floating
        else pinocchio.buildModelFromUrdf(robot["urdf"])
    )
    weightless = source.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    model.gravity.linear = numpy.zeros(3) if weightless else source.opt.gravity
    names = {}
    for j in range(source.njnt):
        name = mujoco.mj_id2name(source, mujoco.mjtObj.mjOBJ_JOINT, j) or f"joint_{j}"
        names[name] = (
            source.jnt_qposadr[j], source.jnt_dofadr[j], source.qpos0[source.jnt_qposadr[j]])
    assert model.nv == source.nv
    source.opt.disableflags |= (
        mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    )
    source.opt.density = source.opt.viscosity = 0
    data, random = mujoco.MjData(source), numpy.random.default_rng(1)
    for _ in range(5):
        data.qpos[:] = source.qpos0
        step = random.normal(size=source.nv)
        mujoco.mj_integratePos(source, data.qpos, step, 1.0)
        data.qvel[:] = random.normal(size=source.nv)
        mujoco.mj_forward(source, data)
        q, v, order = state_of(model, names, data)
        mass = numpy.zeros((source.nv, source.nv))
        mujoco.mj_fullM(source, data, mass)
        turn = numpy.eye(source.nv)
        acceleration = random.normal(size=source.nv)
        force = mass @ acceleration + data.qfrc_bias
        pin = pinocchio.Data(model)
        a = numpy.zeros(model.nv)
        for place, dof in enumerate(order):
            a[place] = acceleration[dof]
        if floating:
            rotation = numpy.zeros(9)
            mujoco.mju_quat2Mat(rotation, data.qpos[3:7])
            rotation = rotation.reshape(3, 3)
            # Pinocchio's base acceleration is spatial, in the frame of the base.
            a[:3] = rotation.T @ acceleration[:3] - numpy.cross(v[3:6], v[:3])
            turn[:3, :3] = rotation
        found = turn @ pinocchio.rnea(model, pin, q, v, a)
        for name, inertia in robot.get("rotor_inertia", {}).items():
            place = model.joints[model.getJointId(name)].idx_v
            found[place] += inertia * a[place]
        expected = force[order]
        size = numpy.abs(expected).max()
        numpy.testing.assert_allclose(found, expected, atol=1e-9 * max(1, size))


def written(tmp_path, bodies, rest=""):
    file = tmp_path / "robot.xml"
    file.write_text(f"<mujoco><worldbody>{bodies}</worldbody>{rest}</mujoco>")
    return file


GEOM = '<geom size="0.1"/>'
FREE = f'<body name="{{}}"><freejoint/>{GEOM}</body>'


def test_ball_joints_are_errors(tmp_path):
    file = written(tmp_path, f'<body><joint name="hip" type="ball"/>{GEOM}</body>')
    with pytest.raises(ValueError, match="'hip' is neither a hinge nor a slide"):
        conddp.from_mjcf(file)


def test_one_of_several_bodies_is_chosen(tmp_path):
    file = written(tmp_path, FREE.format("robot") + FREE.format("ball"))
    with pytest.raises(ValueError, match="choose one with body=.*robot.*ball"):
        conddp.from_mjcf(file)
    with pytest.raises(ValueError, match="'box' is no body in the world"):
        conddp.from_mjcf(file, body="box")
    assert conddp.from_mjcf(file, body="robot")["base"] == "floating"


def test_named_keyframes_are_states_of_an_srdf(tmp_path):
    leg = '<body pos="0 0 -0.4"><joint name="knee" axis="0 1 0"/><geom size="0.05" pos="0 0 -0.4"/></body>'
    legs = "".join(
        f'<body pos="{x} 0 0"><joint name="hip{x}" axis="0 1 0"/><geom size="0.05" pos="0 0 -0.2"/>'
        f'{leg.replace("knee", f"knee{x}")}</body>'
        for x in (-1, 1)
    )
    body = f'<body name="trunk"><freejoint/><geom size="0.2"/>{legs}</body>'
    key = '<keyframe><key qpos="0 0 0.7 1 0 0 0 0.3 -0.6 0.3 -0.6"/>{}</keyframe>'
    robot = conddp.from_mjcf(written(tmp_path, body, key.format("")))
    assert not (tmp_path / "robot.srdf").exists() and "key_0" in robot["configurations"]
    home = '<key name="home" qpos="1 2 0.75 1 0 0 0 0.2 -0.4 0.2 -0.4"/>'
    robot = conddp.from_mjcf(written(tmp_path, body, key.format(home)))
    states = ElementTree.parse(tmp_path / "robot.srdf").getroot().findall("group_state")
    assert [state.get("name") for state in states] == ["home"]
    by_srdf = conddp.problem(
        {
            "conddp": 1, "name": "rest", "gravity": [0, 0, 0],
            "robot": {"urdf": robot["urdf"], "base": "floating", "srdf": "robot.srdf"},
            "initial_state": {"configuration": "home"},
            "phases": [{"name": "go", "knots": 2, "dt": 0.01}],
            "costs": {"effort": {"residual": "control"}},
        },
        tmp_path,
    )
    start = dict(zip(by_srdf.names["x"], by_srdf.solve(verify=False).x[0]))
    assert [start[f"base/{axis}"] for axis in ("x", "y", "z", "qw")] == [1, 2, 0.75, 1]
    assert [start["q/hip1"], start["q/knee1"]] == [0.2, -0.4]


def test_joints_with_actuators_are_actuated(tmp_path):
    arm = (
        f'<body><joint name="a"/>{GEOM}<body pos="0 0 1"><joint name="b"/>{GEOM}</body></body>'
    )
    motor = '<actuator><motor joint="b" gear="3" ctrlrange="-2 2"/></actuator>'
    robot = conddp.from_mjcf(written(tmp_path, arm, motor))
    assert robot["actuation"] == {"joints": ["b"]}
    joints = pinocchio.buildModelFromUrdf(robot["urdf"])
    assert joints.effortLimit.tolist() == [0, 6]
    motors = '<actuator><motor joint="a"/><position jointinparent="b"/></actuator>'
    assert "actuation" not in conddp.from_mjcf(written(tmp_path, arm, motors))
    assert "actuation" not in conddp.from_mjcf(written(tmp_path, arm))
    tendon = (
        '<tendon><fixed name="t"><joint joint="a" coef="1"/></fixed></tendon>'
        '<actuator><motor tendon="t"/><motor joint="b"/></actuator>'
    )
    with pytest.warns(UserWarning, match="tendons are left out"):
        assert "actuation" not in conddp.from_mjcf(written(tmp_path, arm, tendon))

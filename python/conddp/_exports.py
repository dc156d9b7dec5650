"""Motions as files of other viewers: MCAP (Foxglove, ROS 2) and Rerun."""

import base64
import json
import re
from typing import TYPE_CHECKING, Any, Dict, Iterator, List, Optional, Tuple
from xml.etree import ElementTree

import numpy

from ._extras import needed

if TYPE_CHECKING:
    from . import Answer

_SEPARATOR = "\n" + 80 * "=" + "\nMSG: "
_TIME = "builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"
_DURATION = "builtin_interfaces/Duration", "int32 sec\nuint32 nanosec\n"
_HEADER = "std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"
_VECTOR = "geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"
_QUATERNION = "geometry_msgs/Quaternion", "float64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
_TRANSFORM = (
    "geometry_msgs/Transform",
    "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
)
_STAMPED = (
    "geometry_msgs/TransformStamped",
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
)
_POINT = (
    "trajectory_msgs/JointTrajectoryPoint",
    "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
    "builtin_interfaces/Duration time_from_start\n",
)
#: Definitions of the messages and of what they are made of.
_MESSAGES = {
    "std_msgs/msg/Float64": ("float64 data\n", ()),
    "std_msgs/msg/String": ("string data\n", ()),
    "sensor_msgs/msg/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
        "float64[] effort\n",
        (_HEADER, _TIME),
    ),
    "trajectory_msgs/msg/JointTrajectory": (
        "std_msgs/Header header\nstring[] joint_names\n"
        "trajectory_msgs/JointTrajectoryPoint[] points\n",
        (_HEADER, _TIME, _POINT, _DURATION),
    ),
    "tf2_msgs/msg/TFMessage": (
        "geometry_msgs/TransformStamped[] transforms\n",
        (_STAMPED, _HEADER, _TIME, _TRANSFORM, _VECTOR, _QUATERNION),
    ),
}


def _definition(name: str) -> str:
    text, parts = _MESSAGES[name]
    return text + "".join(_SEPARATOR + part + "\n" + own for part, own in parts)


def _stamp(nanoseconds: int) -> Dict[str, int]:
    return {"sec": nanoseconds // 10**9, "nanosec": nanoseconds % 10**9}


def _topic(name: str) -> str:
    """A name of a column as a ROS name has it: letters, digits, '_' and '/'."""
    return re.sub(r"[^A-Za-z0-9_/]", "_", name)


def _controls(answer: "Answer") -> numpy.ndarray:
    if isinstance(answer.u, list):
        raise ValueError("controls differ between phases: take answer.x and answer.u")
    return answer.u


class _Joints:
    """Columns of the joints of an answer: positions, velocities, and controls of their names."""

    def __init__(self, names: Dict[str, Any]):
        x = {name: i for i, name in enumerate(names["x"])}
        u = {name: i for i, name in enumerate(names["u"])}
        self.names = [n[2:] for n in x if n.startswith("q/") and "v/" + n[2:] in x]
        self.q = [x["q/" + name] for name in self.names]
        self.v = [x["v/" + name] for name in self.names]
        self.u = [u.get("u/" + name) for name in self.names]

    def effort(self, u: numpy.ndarray) -> List[float]:
        """Of all joints; 0 of those without an actuator."""
        return [0.0 if i is None else float(u[i]) for i in self.u]


def _bases(answer: "Answer") -> List[Tuple[str, int]]:
    """The free bodies: name of the frame, and column of the first number of the pose."""
    x = answer.names["x"]
    files = [robot["file"] for robot in answer.document["problem"]["robots"]]
    found = []
    for i, name in enumerate(x):
        if name.endswith("base/x") and i + 6 < len(x) and x[i + 6] == name[:-1] + "qw":
            # The frame of a single robot has the name of the link, as in its robot description.
            frame = _root_link(files[0]) if len(files) == 1 and name == "base/x" else name[:-2]
            found.append((frame, i))
    return found


def _root_link(file: str) -> str:
    robot = ElementTree.parse(file).getroot()
    children = {child.get("link") for child in robot.iterfind("joint/child")}
    return next(
        n for n in (link.get("name", "") for link in robot.iterfind("link")) if n not in children
    )


def write_mcap(answer: "Answer", file: str, start: float) -> None:
    library = needed("mcap_ros2.writer", "mcap", "to_mcap()")
    names, t, x, u = answer.names, answer.t, answer.x, _controls(answer)
    joints, bases, robots = _Joints(names), _bases(answer), answer.document["problem"]["robots"]
    stamps = [round((start + float(time)) * 1e9) for time in t]
    with open(file, "wb") as out, library.Writer(out) as writer:
        schemas: Dict[str, Any] = {}

        def write(topic: str, kind: str, message: Dict[str, Any], at: int) -> None:
            if kind not in schemas:
                schemas[kind] = writer.register_msgdef(kind, _definition(kind))
            writer.write_message(topic, schemas[kind], message, log_time=at)

        if len(robots) == 1:
            with open(robots[0]["file"], encoding="utf-8") as urdf:
                text = urdf.read()
            write("/robot_description", "std_msgs/msg/String", {"data": text}, stamps[0])
        if joints.names:
            points = [
                {
                    "positions": x[k, joints.q].tolist(),
                    "velocities": x[k, joints.v].tolist(),
                    "accelerations": [],
                    "effort": joints.effort(u[k]) if k < len(u) else [],
                    "time_from_start": _stamp(stamps[k] - stamps[0]),
                }
                for k in range(len(t))
            ]
            message = {
                "header": {"stamp": _stamp(stamps[0]), "frame_id": ""},
                "joint_names": joints.names,
                "points": points,
            }
            write("/joint_trajectory", "trajectory_msgs/msg/JointTrajectory", message, stamps[0])
        for k, at in enumerate(stamps):
            if joints.names:
                state = {
                    "header": {"stamp": _stamp(at), "frame_id": ""},
                    "name": joints.names,
                    "position": points[k]["positions"],
                    "velocity": points[k]["velocities"],
                    "effort": points[k]["effort"],
                }
                write("/joint_states", "sensor_msgs/msg/JointState", state, at)
            if bases:
                transforms = [_transform(frame, x[k, i : i + 7], at) for frame, i in bases]
                write("/tf", "tf2_msgs/msg/TFMessage", {"transforms": transforms}, at)
            for kind, columns, row in (
                ("x", names["x"], x[k]),
                ("u", names["u"], u[k : k + 1].ravel()),
            ):
                for name, value in zip(columns, row):
                    topic = f"/{kind}/{_topic(name.removeprefix(kind + '/'))}"
                    write(topic, "std_msgs/msg/Float64", {"data": float(value)}, at)


def _transform(frame: str, pose: numpy.ndarray, at: int) -> Dict[str, Any]:
    return {
        "header": {"stamp": _stamp(at), "frame_id": "world"},
        "child_frame_id": frame,
        "transform": {
            "translation": dict(zip("xyz", pose[:3].tolist())),
            "rotation": dict(zip("xyzw", pose[3:].tolist())),
        },
    }


def scene_of(page: str) -> Optional[Dict[str, Any]]:
    """What the page of a report draws; None if it draws nothing."""
    found = re.search(
        r'<script type="application/json" id="report-data">(.*?)</script>', page, re.S
    )
    if found is None:
        raise ValueError("the page of the report has no data")
    scene: Optional[Dict[str, Any]] = json.loads(found.group(1))["solutions"][0]["scene"]
    return scene


def write_rerun(answer: "Answer", file: str) -> None:
    rr = needed("rerun", "rerun", "to_rerun()")
    names, t, x, u = answer.names, answer.t, answer.x, _controls(answer)
    recording = rr.RecordingStream(answer.document["problem"]["name"])
    recording.save(file)
    times = [rr.TimeColumn("t", duration=t)]
    for kind, columns, rows in (("x", names["x"], x), ("u", names["u"], u)):
        for name, unit, values in zip(columns, names["units"][kind], rows.T):
            path = rr.new_entity_path([kind, *name.removeprefix(kind + "/").split("/")])
            recording.log(path, rr.SeriesLines(names=f"{name} [{unit}]"), static=True)
            own = [rr.TimeColumn("t", duration=t[: len(values)])]
            recording.send_columns(path, own, rr.Scalars.columns(scalars=values))
    scene = scene_of(answer.report())
    if scene is not None:
        _draw(rr, recording, times, len(t), scene)
    recording.flush()
    recording.disconnect()


def _draw(rr: Any, recording: Any, times: List[Any], nodes: int, scene: Dict[str, Any]) -> None:
    """Bodies with their shapes; each has its pose in the world at all times."""
    recording.log("scene", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    poses = numpy.array(scene["poses"], dtype=float).reshape(nodes, len(scene["bodies"]), 7)
    for i, body in enumerate(scene["bodies"]):
        parts = ["scene", body["name"]]
        path = rr.new_entity_path(parts)
        transforms = rr.Transform3D.columns(translation=poses[:, i, :3], quaternion=poses[:, i, 3:])
        recording.send_columns(path, times, transforms)
        for j, shape in enumerate(body["shapes"]):
            for own, form in _forms(rr, shape, scene.get("meshes", [])):
                at = rr.new_entity_path([*parts, f"{shape.get('link', 'shape')}_{j}{own}"])
                place = shape["placement"]
                pose = rr.Transform3D(
                    translation=place[:3], quaternion=rr.Quaternion(xyzw=place[3:])
                )
                recording.log(at, pose, form, static=True)


def _forms(rr: Any, shape: Dict[str, Any], meshes: List[Any]) -> Iterator[Tuple[str, Any]]:
    """A shape of the report as archetypes of Rerun; marks without a size are left out."""
    kind, color = shape["kind"], shape.get("color")
    look = {"colors": [color] if color else None, "fill_mode": "solid"}
    if kind == "box":
        yield "", rr.Boxes3D(sizes=[shape["size"]], **look)
    elif kind == "sphere":
        yield "", rr.Ellipsoids3D(radii=[shape["radius"]], **look)
    elif kind == "ellipsoid":
        yield "", rr.Ellipsoids3D(half_sizes=[shape["radii"]], **look)
    elif kind == "cylinder":
        yield "", rr.Cylinders3D(lengths=[shape["length"]], radii=[shape["radius"]], **look)
    elif kind == "mesh":
        for i, part in enumerate(meshes[shape["mesh"]]):
            vertices, triangles = _mesh(part)
            yield f"_{i}", rr.Mesh3D(
                vertex_positions=vertices * shape["scale"],
                triangle_indices=triangles,
                albedo_factor=color or part.get("color"),
            )


def _mesh(part: Dict[str, Any]) -> Tuple[numpy.ndarray, numpy.ndarray]:
    """Vertices, which the page stores as steps from a corner, and triangles."""
    steps = numpy.frombuffer(base64.b64decode(part["positions"]), "<u2").reshape(-1, 3)
    width = "<u2" if len(steps) <= 1 << 16 else "<u4"
    triangles = numpy.frombuffer(base64.b64decode(part["triangles"]), width).reshape(-1, 3)
    return numpy.array(part["low"]) + part["step"] * steps, triangles.astype(numpy.uint32)

"""Robots of MuJoCo's XML files (MJCF), written as URDF. Needs the package mujoco."""

import os
import pathlib
import warnings
from typing import Any, Dict, List, Optional, Union
from xml.etree import ElementTree

import numpy

from ._extras import needed

_FREE, _BALL, _SLIDE, _HINGE = range(4)
#: Actuators at joints; for hinges and slides, the second kind (in the parent's axes) is the same.
_JOINT_TRANSMISSIONS = (0, 1)
#: Stands for limits that the file does not give; URDF has no way to leave them out of a joint with a range.
_UNLIMITED = 1e9


def _matrix(quaternion: numpy.ndarray) -> numpy.ndarray:
    """The rotation of a unit quaternion w, x, y, z."""
    w, x, y, z = quaternion
    return numpy.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _rpy(rotation: numpy.ndarray) -> List[float]:
    """Roll, pitch and yaw about fixed axes."""
    pitch = numpy.arctan2(-rotation[2, 0], numpy.hypot(rotation[0, 0], rotation[1, 0]))
    if numpy.hypot(rotation[0, 0], rotation[1, 0]) < 1e-9:  # yaw and roll turn about one axis
        return [numpy.arctan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0]
    return [
        numpy.arctan2(rotation[2, 1], rotation[2, 2]),
        pitch,
        numpy.arctan2(rotation[1, 0], rotation[0, 0]),
    ]


def _text(numbers: Any) -> str:
    return " ".join(repr(float(number)) for number in numpy.atleast_1d(numbers))


def _origin(parent: ElementTree.Element, position: numpy.ndarray, quaternion: Any) -> None:
    ElementTree.SubElement(
        parent, "origin", xyz=_text(position), rpy=_text(_rpy(_matrix(quaternion)))
    )


class _Writer:
    def __init__(
        self, mujoco: Any, model: Any, folder: pathlib.Path, name: str, body: Optional[str]
    ):
        self.mujoco, self.model, self.folder, self.name = mujoco, model, folder, name
        self.bodies = list(range(1, model.nbody))
        if body is not None:
            root = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, body)
            if root < 1 or model.body_parentid[root] != 0:
                raise ValueError(f"'{body}' is no body in the world of '{name}'")
            self.bodies = [b for b in self.bodies if model.body_rootid[b] == root]
        self.root = ElementTree.Element("robot", name=name)
        self.floating: Optional[int] = None
        self.offsets = {0: numpy.zeros(3)}  # of the links' frames from those of their bodies
        self.rotor_inertia: Dict[str, float] = {}
        self.joints: Dict[int, str] = {}

    def named(self, kind: str, index: int) -> str:
        kinds = self.mujoco.mjtObj
        found = self.mujoco.mj_id2name(self.model, getattr(kinds, f"mjOBJ_{kind.upper()}"), index)
        return found or f"{kind}_{index}"

    def write(self) -> Dict[str, Any]:
        m = self.model
        first = [b for b in self.bodies if m.body_parentid[b] == 0]
        free = [b for b in first if m.body_jntnum[b] and m.jnt_type[m.body_jntadr[b]] == _FREE]
        if free and len(first) > 1:
            raise ValueError(
                f"'{self.name}' has several bodies in the world; choose one with body=..., of "
                f"{[self.named('body', b) for b in first]}"
            )
        if free:
            self.floating = free[0]
        else:
            self.link("world", 0)
        for body in self.bodies:
            self.body(body)
        for site in range(m.nsite):
            if m.site_bodyid[site] in self.offsets:
                self.site(site)
        left_out = [n for n, count in (("equality constraints", m.neq), ("tendons", m.ntendon)) if count]
        if left_out:
            warnings.warn(f"'{self.name}': {' and '.join(left_out)} are left out", stacklevel=4)
        ElementTree.indent(self.root)
        file = self.folder / f"{self.name}.urdf"
        ElementTree.ElementTree(self.root).write(file, encoding="utf-8", xml_declaration=True)
        configurations = self.configurations()
        self.srdf(configurations)
        friction = any(m.dof_frictionloss[m.jnt_dofadr[joint]] > 0 for joint in self.joints)
        robot: Dict[str, Any] = {
            "urdf": str(file.resolve()),
            "base": "fixed" if self.floating is None else "floating",
            "passive": {"damping": "urdf", "friction": "urdf" if friction else "none"},
            "configurations": configurations,
        }
        driven = [name for joint, name in self.joints.items() if self.actuators(joint)]
        by_joints = all(kind in _JOINT_TRANSMISSIONS for kind in m.actuator_trntype)
        if by_joints and 0 < len(driven) < len(self.joints):
            robot["actuation"] = {"joints": driven}
        if self.rotor_inertia:
            robot["rotor_inertia"] = self.rotor_inertia
        return robot

    def link(self, name: str, body: Optional[int]) -> ElementTree.Element:
        link = ElementTree.SubElement(self.root, "link", name=name)
        m = self.model
        if body:
            if m.body_mass[body] > 0:
                inertial = ElementTree.SubElement(link, "inertial")
                _origin(inertial, m.body_ipos[body] - self.offsets[body], m.body_iquat[body])
                ElementTree.SubElement(inertial, "mass", value=_text(m.body_mass[body]))
                x, y, z = m.body_inertia[body]
                ElementTree.SubElement(
                    inertial, "inertia", ixx=_text(x), iyy=_text(y), izz=_text(z),
                    ixy="0", ixz="0", iyz="0",
                )
            for geom in range(m.body_geomadr[body], m.body_geomadr[body] + m.body_geomnum[body]):
                self.geom(link, geom, self.offsets[body])
        return link

    def body(self, body: int) -> None:
        m = self.model
        first, count = m.body_jntadr[body], m.body_jntnum[body]
        if body == self.floating:
            if count > 1 or m.dof_armature[m.jnt_dofadr[first]] > 0:
                raise ValueError(f"'{self.name}': joints or armature beside the free joint of the base")
            self.offsets[body] = numpy.zeros(3)
            self.link(self.named("body", body), body)
            return
        position, quaternion = m.body_pos[body], m.body_quat[body]
        parent = m.body_parentid[body]
        above = self.named("body", parent) if parent else "world"
        before = self.offsets[parent] - position  # from the body's frame to the frame above
        turn = _matrix(quaternion)
        at = numpy.zeros(3)
        for joint in range(first, first + count):
            kind = m.jnt_type[joint]
            if kind not in (_SLIDE, _HINGE):
                raise ValueError(f"joint '{self.named('joint', joint)}' is neither a hinge nor a slide")
            at = m.jnt_pos[joint].copy()
            last = joint == first + count - 1
            below = self.named("body", body) if last else f"{self.named('joint', joint)}_link"
            if joint == first:
                self.joint(joint, above, below, turn @ at - before, quaternion)
            else:
                self.joint(joint, above, below, at - m.jnt_pos[joint - 1], [1, 0, 0, 0])
            if not last:
                self.link(below, None)
            above = below
        self.offsets[body] = at
        if count == 0:
            fixed = ElementTree.SubElement(
                self.root, "joint", name=f"{self.named('body', body)}_fixed", type="fixed"
            )
            self.ends(fixed, above, self.named("body", body), -before, quaternion)
        self.link(self.named("body", body), body)

    def ends(
        self,
        joint: ElementTree.Element,
        parent: str,
        child: str,
        position: numpy.ndarray,
        quaternion: Any,
    ) -> None:
        ElementTree.SubElement(joint, "parent", link=parent)
        ElementTree.SubElement(joint, "child", link=child)
        _origin(joint, position, quaternion)

    def joint(
        self, index: int, parent: str, child: str, position: numpy.ndarray, quaternion: Any
    ) -> None:
        m = self.model
        name = self.joints[index] = self.named("joint", index)
        limited = bool(m.jnt_limited[index])
        hinge = m.jnt_type[index] == _HINGE
        kind = ("revolute" if limited else "continuous") if hinge else "prismatic"
        joint = ElementTree.SubElement(self.root, "joint", name=name, type=kind)
        self.ends(joint, parent, child, position, quaternion)
        ElementTree.SubElement(joint, "axis", xyz=_text(m.jnt_axis[index]))
        limit = ElementTree.SubElement(
            joint, "limit", effort=_text(self.effort(index)), velocity=_text(_UNLIMITED)
        )
        if limited or not hinge:
            low, high = m.jnt_range[index] - m.qpos0[m.jnt_qposadr[index]] if limited else (
                -_UNLIMITED, _UNLIMITED)
            limit.set("lower", _text(low))
            limit.set("upper", _text(high))
        dof = m.jnt_dofadr[index]
        ElementTree.SubElement(
            joint, "dynamics", damping=_text(m.dof_damping[dof]), friction=_text(m.dof_frictionloss[dof])
        )
        if m.dof_armature[dof] > 0:
            self.rotor_inertia[name] = float(m.dof_armature[dof])

    def actuators(self, joint: int) -> List[int]:
        m = self.model
        kinds = numpy.isin(m.actuator_trntype, _JOINT_TRANSMISSIONS)
        return [a for a in range(m.nu) if kinds[a] and m.actuator_trnid[a, 0] == joint]

    def effort(self, joint: int) -> float:
        """Largest force or torque of the actuators of a joint; 0 without any."""
        m, total = self.model, 0.0
        for a in self.actuators(joint):
            largest = _UNLIMITED
            if m.actuator_forcelimited[a]:
                largest = min(largest, numpy.abs(m.actuator_forcerange[a]).max())
            if m.actuator_ctrllimited[a] and m.actuator_biastype[a] == 0:
                gain = numpy.abs(m.actuator_gainprm[a, 0])
                largest = min(largest, gain * numpy.abs(m.actuator_ctrlrange[a]).max())
            total += largest if largest == _UNLIMITED else largest * abs(m.actuator_gear[a, 0])
        if m.jnt_actfrclimited[joint]:
            total = min(total, numpy.abs(m.jnt_actfrcrange[joint]).max())
        return min(total, _UNLIMITED)

    def site(self, site: int) -> None:
        m = self.model
        body = m.site_bodyid[site]
        above = self.named("body", body) if body else "world"
        if body == 0 and self.floating is not None:
            return
        taken = {link.get("name") for link in self.root.iter("link")}
        name = self.named("site", site)
        name = name if name not in taken else f"{name}_site"
        self.link(name, None)
        joint = ElementTree.SubElement(self.root, "joint", name=f"{name}_fixed", type="fixed")
        self.ends(joint, above, name, m.site_pos[site] - self.offsets[body], m.site_quat[site])

    def geom(self, link: ElementTree.Element, geom: int, offset: numpy.ndarray) -> None:
        m, types = self.model, self.mujoco.mjtGeom
        kind, size = m.geom_type[geom], m.geom_size[geom]
        collides = m.geom_contype[geom] or m.geom_conaffinity[geom]
        shapes = []  # tag, attributes, distance along z
        if kind == types.mjGEOM_SPHERE:
            shapes = [("sphere", {"radius": _text(size[0])}, 0)]
        elif kind == types.mjGEOM_BOX:
            shapes = [("box", {"size": _text(2 * size)}, 0)]
        elif kind in (types.mjGEOM_CYLINDER, types.mjGEOM_CAPSULE):
            shapes = [("cylinder", {"radius": _text(size[0]), "length": _text(2 * size[1])}, 0)]
            if kind == types.mjGEOM_CAPSULE:
                shapes += [("sphere", {"radius": _text(size[0])}, end * size[1]) for end in (-1, 1)]
        elif kind == types.mjGEOM_MESH:
            shapes = [("mesh", {"filename": self.mesh(m.geom_dataid[geom])}, 0)]
        turn = _matrix(m.geom_quat[geom])
        for tag, attributes, along in shapes:
            for role in ("visual", "collision") if collides else ("visual",):
                element = ElementTree.SubElement(link, role)
                place = m.geom_pos[geom] - offset + turn @ [0, 0, along]
                _origin(element, place, m.geom_quat[geom])
                shape = ElementTree.SubElement(element, "geometry")
                ElementTree.SubElement(shape, tag, attributes)

    def mesh(self, mesh: int) -> str:
        """Writes a mesh as OBJ, as MuJoCo's compiler placed and scaled it; returns its file."""
        m = self.model
        file = self.folder / f"{self.name}_{self.named('mesh', mesh)}.obj"
        if not file.exists():
            first, count = m.mesh_vertadr[mesh], m.mesh_vertnum[mesh]
            faces = m.mesh_face[m.mesh_faceadr[mesh] : m.mesh_faceadr[mesh] + m.mesh_facenum[mesh]]
            with open(file, "w", encoding="ascii") as out:
                vertices = m.mesh_vert[first : first + count].ravel().tolist()
                out.write("v %.9g %.9g %.9g\n" * count % tuple(vertices))
                out.write("f %d %d %d\n" * len(faces) % tuple((faces + 1).ravel().tolist()))
        return file.name

    def configurations(self) -> Dict[str, Any]:
        """Keyframes, as configurations of the robot."""
        m, out = self.model, {}
        for key in range(m.nkey):
            q = m.key_qpos[key]
            joints = {
                name: float(q[m.jnt_qposadr[j]] - m.qpos0[m.jnt_qposadr[j]])
                for j, name in self.joints.items()
            }
            own: Dict[str, Any] = {"joints": joints}
            if self.floating is not None:
                at = m.jnt_qposadr[m.body_jntadr[self.floating]]
                own["base"] = {
                    "position": q[at : at + 3].tolist(),
                    "orientation": [q[at + 4], q[at + 5], q[at + 6], q[at + 3]],
                }
                own["base"]["orientation"] = [float(n) for n in own["base"]["orientation"]]
            out[self.named("key", key)] = own
        return out


    def srdf(self, configurations: Dict[str, Any]) -> None:
        """Writes keyframes that have names as group states, where `conddp init` looks for postures."""
        kinds = self.mujoco.mjtObj
        named = [self.mujoco.mj_id2name(self.model, kinds.mjOBJ_KEY, k) for k in range(self.model.nkey)]
        if not any(named):
            return
        root = ElementTree.Element("robot", name=self.name)
        for name in filter(None, named):
            state = ElementTree.SubElement(root, "group_state", name=name, group="all")
            values = {joint: [value] for joint, value in configurations[name]["joints"].items()}
            if "base" in configurations[name]:
                base = configurations[name]["base"]
                values["root_joint"] = [*base["position"], *base["orientation"]]
            for joint, numbers in values.items():
                ElementTree.SubElement(state, "joint", name=joint, value=_text(numbers))
        ElementTree.indent(root)
        file = self.folder / f"{self.name}.srdf"
        ElementTree.ElementTree(root).write(file, encoding="utf-8", xml_declaration=True)


def from_mjcf(
    file: Union[str, "os.PathLike[str]"],
    folder: Optional[Union[str, "os.PathLike[str]"]] = None,
    body: Optional[str] = None,
) -> Dict[str, Any]:
    """Writes the robot of an MJCF file as URDF, and returns what the key `robot` of a problem takes.

    MuJoCo's compiler reads the file. Bodies, hinges and slides, a free base, armature (rotor
    inertia), damping, ranges, actuators and their limits, sites (frames), keyframes
    (configurations, and an SRDF beside the URDF), shapes and meshes come along. Joint positions
    count from the file's own reference (qpos0).

    folder: where the URDF and its meshes are written; by default that of the file.
    body: takes only this body of the world with what hangs on it; needed if the file has several.
    """
    mujoco = needed("mujoco", "mujoco", "from_mjcf")
    file = pathlib.Path(file)
    model = mujoco.MjModel.from_xml_path(os.fspath(file))
    folder = pathlib.Path(folder) if folder is not None else file.parent
    folder.mkdir(parents=True, exist_ok=True)
    return _Writer(mujoco, model, folder, file.stem, body).write()

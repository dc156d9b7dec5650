"""The robot of a problem as Pinocchio has it, and the values that a problem file gives by name."""

import fnmatch

import numpy as np
import pinocchio as pin

from conddp_tool import Untranslatable

BASE_PARTS = ("x", "y", "z", "rx", "ry", "rz")
BASE_RATES = ("vx", "vy", "vz", "wx", "wy", "wz")


def require(holds, what):
    if not holds:
        raise Untranslatable(what)


def locked(model, positions):
    """The model with some joints fixed for ever."""
    if not positions:
        return model
    q = pin.neutral(model)
    for joint, position in positions.items():
        q[model.joints[model.getJointId(joint)].idx_q] = position
    return pin.buildReducedModel(model, [model.getJointId(joint) for joint in positions], q)


class Robot:
    """Model, names of its columns, and states as vectors (q, v)."""

    def __init__(self, problem):
        require("robot" in problem, "problems without exactly one robot")
        spec = problem["robot"]
        self.check(spec)
        self.floating = spec["base"] == "floating"
        root = (pin.JointModelFreeFlyer(),) if self.floating else ()
        self.model = locked(pin.buildModelFromUrdf(spec["urdf"], *root), spec["locked_joints"])
        self.model.gravity.linear = np.array(problem["gravity"])
        for joint, name in zip(self.model.joints, self.model.names):
            require(joint.nq == joint.nv or joint.nq == 7, f"continuous joint '{name}'")
        for link, payload in spec["payloads"].items():
            self.add_payload(link, payload)
        for joint, inertia in spec["rotor_inertia"].items():
            self.model.armature[self.model.joints[self.model.getJointId(joint)].idx_v] = inertia
        self.joints = list(self.model.names)[2 if self.floating else 1:]
        self.configurations = spec["configurations"]
        self.initial = self.state(problem["initial_state"])

    @staticmethod
    def check(spec):
        require(spec["base"] in ("fixed", "floating"), f"robot.base: {spec['base']}")
        if spec["base"] == "fixed":
            require(spec["placement"] == {"position": [0, 0, 0], "orientation": [0, 0, 0, 1]},
                    "robot.placement")
        require(not spec["external_wrenches"], "robot.external_wrenches")
        require(spec["actuation"] == "full", "robot.actuation")
        require(spec["passive"]["damping"] == spec["passive"]["friction"] == "none",
                "robot.passive")
        require(spec["mimic"] == "ignore", "robot.mimic")

    def add_payload(self, link, payload):
        inertia = payload.get("inertia")
        about_com = np.zeros((3, 3)) if inertia is None else np.array(
            [[inertia["i" + "".join(sorted(a + b))] for b in "xyz"] for a in "xyz"])
        frame = self.model.frames[self.frame(link)]
        self.model.appendBodyToJoint(
            frame.parentJoint, pin.Inertia(payload["mass"], np.array(payload["com"]), about_com),
            frame.placement)

    def frame(self, name):
        require(self.model.existFrame(name), f"frame '{name}'")
        return self.model.getFrameId(name)

    def state(self, spec):
        """A state as the file writes it: by name, by parts, or as all its numbers."""
        if isinstance(spec, str):
            return self.initial if spec == "initial" else self.state(self.configurations[spec])
        q, v = pin.neutral(self.model), np.zeros(self.model.nv)
        if "state" in spec:
            return np.array(spec["state"])
        if "configuration" in spec:
            q = self.state(spec["configuration"])[:self.model.nq].copy()
        require(not set(spec) - {"configuration", "base", "joints", "velocity", "displaced"},
                f"a state with {sorted(spec)}")
        base = spec.get("base", {})
        q[0:3] = base.get("position", q[0:3]) if self.floating else q[0:3]
        if "orientation" in base:
            q[3:7] = base["orientation"]
        for name, value in spec.get("joints", {}).items():
            q[self.model.joints[self.model.getJointId(name)].idx_q] = value
        if "displaced" in spec:
            place = self.displacement(spec["displaced"], q) * pin.XYZQUATToSE3(q[:7])
            q[:7] = pin.SE3ToXYZQUAT(place)
        velocity = spec.get("velocity", {})
        if "base" in velocity:
            v[0:6] = velocity["base"]["linear"] + velocity["base"]["angular"]
        for name, value in velocity.get("joints", {}).items():
            v[self.model.joints[self.model.getJointId(name)].idx_v] = value
        return np.concatenate([q, v])

    def displacement(self, motion, q):
        """What moves the world with a base that goes x, y, yaw in its own heading."""
        require(self.floating, "a displaced state of a base that does not float")
        base = pin.XYZQUATToSE3(q[:7])
        ahead = base.rotation[:, 0]
        heading = pin.exp3(np.array([0, 0, np.arctan2(ahead[1], ahead[0])]))
        turn, at = pin.exp3(np.array([0, 0, motion[2]])), base.translation
        step = heading @ np.array([motion[0], motion[1], 0.0])
        return pin.SE3(turn, at + step - turn @ at)

    def state_names(self):
        """Names of the tangent components of a state."""
        base = self.floating
        return ([f"base/{part}" for part in BASE_PARTS if base]
                + [f"q/{joint}" for joint in self.joints]
                + [f"base/{part}" for part in BASE_RATES if base]
                + [f"v/{joint}" for joint in self.joints])

    def control_names(self):
        return [f"u/{joint}" for joint in self.joints]

    def placement(self, frame, state):
        """A frame's pose in the world."""
        data = self.model.createData()
        pin.framesForwardKinematics(self.model, data, state[:self.model.nq])
        return data.oMf[frame].copy()

    def between(self, first, second, share):
        """The state at a share of the way from one to another."""
        nq = self.model.nq
        q = pin.interpolate(self.model, first[:nq], second[:nq], share)
        return np.concatenate([q, (1 - share) * first[nq:] + share * second[nq:]])

    def center_of_mass(self, state):
        return pin.centerOfMass(self.model, self.model.createData(),
                                state[:self.model.nq]).copy()


def components(spec, names, default):
    """One number for each name, from a number, a list, or a mapping in which an exact name wins,
    then the longer pattern; null is the default. Joints may be named alone."""
    if isinstance(spec, (int, float)):
        return np.full(len(names), float(spec))
    if isinstance(spec, list):
        require(len(spec) == len(names), f"a list of {len(spec)} for {len(names)} components")
        return np.array([default if value is None else value for value in spec], float)
    values = np.full(len(names), float(default))
    for i, name in enumerate(names):
        alone = name.split("/", 1)[1] if name[:2] in ("q/", "u/") else name
        for key in sorted(spec, key=lambda key: ("*" not in key, len(key))):
            if fnmatch.fnmatchcase(name, key) or fnmatch.fnmatchcase(alone, key):
                values[i] = default if spec[key] is None else spec[key]
    return values

#!/usr/bin/env python3
"""Writes tests/systems/data/loops.json: accelerations of robots whose frames are held together.

    scripts/peers/setup
    build/peers/bin/python scripts/peers/loop_fixtures.py

Pinocchio computes inertias, biases, and the Jacobians and accelerations of single frames; the equations
of relative motion and their solution are written out here. Fields: pinocchio (its version), and robots,
each with a URDF file of problems/robots, base, loops (frame, on, kind), and states: configuration q
(quaternions x, y, z, w), velocity v, generalized forces tau, and the acceleration a.
"""

import json
from pathlib import Path

import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[2]
TARGET = ROOT / "tests" / "systems" / "data" / "loops.json"
RANDOM = np.random.default_rng(6)
ROBOTS = [
    ("five_bar_leg", "fixed", [("foot", "foot_b", "planar")]),
    ("arm7", "fixed", [("tool", "link_2", "point")]),
    ("quadruped", "floating", [("lf_foot", "rf_foot", "point"), ("lh_foot", "trunk", "planar")]),
    ("biped", "floating", [("l_sole", "r_sole", "surface")]),
    ("solo12", "floating", [("fl_foot", "hr_foot", "point"), ("fr_foot", "hl_foot", "planar")]),
]
# Directions of planar loops, fixed in the frame that is touched.
NORMAL, TANGENT = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])


def skew(a):
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def relative_rows(model, data, loop):
    """Jacobian and drift of a frame's motion as seen from another one, in that one's axes."""
    world = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    frame, on, kind = loop
    (ra, ja, va, aa), (rb, jb, vb, ab) = (
        (data.oMf[i], pin.getFrameJacobian(model, data, i, world), pin.getFrameVelocity(model, data, i, world),
         pin.getFrameClassicalAcceleration(model, data, i, world))
        for i in (model.getFrameId(frame), model.getFrameId(on)))
    lever, turn = ra.translation - rb.translation, vb.angular
    to_base = rb.rotation.T
    jacobian = to_base @ (ja[:3] - jb[:3] + skew(lever) @ jb[3:])
    speed = va.linear - vb.linear
    seen = speed - np.cross(turn, lever)
    drift = to_base @ (aa.linear - ab.linear - np.cross(ab.angular, lever) - np.cross(turn, speed)
                       - np.cross(turn, seen))
    if kind == "planar":
        return np.vstack([NORMAL, TANGENT]) @ jacobian, np.vstack([NORMAL, TANGENT]) @ drift
    if kind == "point":
        return jacobian, drift
    rotation = to_base @ (ja[3:] - jb[3:])
    rotation_drift = to_base @ (aa.angular - ab.angular - np.cross(turn, va.angular - vb.angular))
    # The twist's components turn with the frame.
    spin = to_base @ (va.angular - vb.angular)
    point = to_base @ seen
    return (np.vstack([jacobian, rotation]),
            np.concatenate([drift - np.cross(spin, point), rotation_drift]))


def acceleration(model, data, q, v, tau, loops):
    zero = np.zeros(model.nv)
    pin.forwardKinematics(model, data, q, v, zero)
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    parts = [relative_rows(model, data, loop) for loop in loops]
    jacobian, drift = np.vstack([p[0] for p in parts]), np.concatenate([p[1] for p in parts])
    pin.crba(model, data, q)
    mass = np.triu(data.M) + np.triu(data.M, 1).T
    bias = pin.nonLinearEffects(model, data, q, v)
    rows = len(drift)
    kkt = np.block([[mass, -jacobian.T], [jacobian, np.zeros((rows, rows))]])
    return np.linalg.solve(kkt, np.concatenate([tau - bias, -drift]))[: model.nv]


def main():
    robots = []
    for name, base, loops in ROBOTS:
        path = str(ROOT / "problems" / "robots" / f"{name}.urdf")
        model = pin.buildModelFromUrdf(path, *([pin.JointModelFreeFlyer()] if base == "floating" else []))
        data, states = model.createData(), []
        for _ in range(3):
            q = pin.integrate(model, pin.neutral(model), RANDOM.uniform(-0.9, 0.9, model.nv))
            v, tau = RANDOM.uniform(-2, 2, model.nv), RANDOM.uniform(-10, 10, model.nv)
            states.append({"q": q.tolist(), "v": v.tolist(), "tau": tau.tolist(),
                           "a": acceleration(model, data, q, v, tau, loops).tolist()})
        robots.append({"urdf": name, "base": base, "states": states,
                       "loops": [{"frame": f, "on": o, "kind": k} for f, o, k in loops]})
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text(json.dumps({"pinocchio": pin.__version__, "robots": robots}) + "\n")
    print(TARGET.name, TARGET.stat().st_size, "bytes")


if __name__ == "__main__":
    main()

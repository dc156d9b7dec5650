#!/usr/bin/env python3
"""Writes tests/robot/data/<robot>.json: what Pinocchio computes for a robot at random states.

    scripts/peers/setup
    build/peers/bin/python scripts/peers/robot_fixtures.py [FOLDER OF FURTHER URDFS]

Without a folder, the robots of problems/robots. Coordinates are conddp's: a continuous joint is one
angle (Pinocchio keeps its cosine and sine), a floating base is (position, quaternion x y z w) and
(linear, angular velocity in the base frame), as in Pinocchio. Angles may be far beyond the limits
and bases turned at random. The file names the version it was made with.

Fields: robot, base (fixed | floating), pinocchio, mass, joints (names in order), nq, nv, gravity
(m/s^2), and samples, each with q, v, a, tau (inverse dynamics), M (joint-space inertia, row-major),
com (world), frames {link: {R: rotation to the world, row-major, p: origin in the world}}.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

ROOT = Path(__file__).resolve().parents[2]
FLOATING = {"quadruped", "free_body", "quadrotor", "hyq", "anymal_b", "solo12", "bolt",
            "talos_reduced", "iris_quadrotor"}
SAMPLES = 2
LARGEST = 60_000  # bytes; beyond: one sample, one frame for each body


def to_pinocchio(model, q):
    """conddp's configuration as Pinocchio writes it."""
    full = np.empty(model.nq)
    k = 0
    for joint in model.joints[1:]:
        if joint.nq == 2 and joint.nv == 1:  # continuous
            full[joint.idx_q:joint.idx_q + 2] = np.cos(q[k]), np.sin(q[k])
            k += 1
        else:
            full[joint.idx_q:joint.idx_q + joint.nq] = q[k:k + joint.nq]
            k += joint.nq
    return full


def random_configuration(model, rng):
    q = []
    for joint in model.joints[1:]:
        if joint.nq == 7:
            turn = rng.normal(size=4)
            q += list(rng.uniform(-1, 1, 3)) + list(turn / np.linalg.norm(turn))
        else:
            q.append(rng.uniform(-3, 3))
    return np.array(q)


def sample(model, data, rng):
    q = random_configuration(model, rng)
    v, a = rng.normal(size=model.nv), rng.normal(size=model.nv)
    full = to_pinocchio(model, q)
    tau = pin.rnea(model, data, full, v, a)
    inertia = pin.crba(model, data, full)
    inertia = np.triu(inertia) + np.triu(inertia, 1).T
    com = pin.centerOfMass(model, data, full)
    pin.framesForwardKinematics(model, data, full)
    frames = {
        frame.name: {"R": data.oMf[i].rotation.ravel().tolist(),
                     "p": data.oMf[i].translation.tolist()}
        for i, frame in enumerate(model.frames)
        if frame.type == pin.FrameType.BODY and frame.name != "universe"
    }
    return {"q": q.tolist(), "v": v.tolist(), "a": a.tolist(), "tau": tau.tolist(),
            "M": inertia.ravel().tolist(), "com": com.tolist(), "frames": frames}


def fixture(path):
    base = "floating" if path.stem in FLOATING else "fixed"
    if base == "floating":
        model = pin.buildModelFromUrdf(str(path), pin.JointModelFreeFlyer())
    else:
        model = pin.buildModelFromUrdf(str(path))
    rng = np.random.default_rng(7)
    data = model.createData()
    samples = [sample(model, data, rng) for _ in range(SAMPLES)]
    names = list(model.names)[1:]
    nq = sum(1 if joint.nv == 1 else joint.nq for joint in model.joints[1:])
    result = {"robot": path.stem, "base": base, "pinocchio": pin.__version__,
              "mass": sum(body.mass for body in list(model.inertias)[1:]), "joints": names,
              "nq": nq, "nv": model.nv, "gravity": model.gravity.linear.tolist(),
              "samples": samples}
    if len(json.dumps(result)) > LARGEST:
        del samples[1:]
        moving = {frame.name for frame in model.frames if frame.type == pin.FrameType.BODY}
        first = {}  # one link for each body
        for frame in model.frames:
            if frame.name in moving and frame.name != "universe":
                first.setdefault(frame.parentJoint, frame.name)
        for s in samples:
            s["frames"] = {name: s["frames"][name] for name in first.values()}
    return result


def main():
    folders = [ROOT / "problems" / "robots"] + [Path(folder) for folder in sys.argv[1:]]
    taken = set()
    for folder in folders:
        for path in sorted(folder.glob("*.urdf")):
            if path.stem in taken:  # ours come first
                print(f"{path}: skipped, a robot of that name is there", file=sys.stderr)
                continue
            taken.add(path.stem)
            target = ROOT / "tests" / "robot" / "data" / f"{path.stem}.json"
            target.write_text(json.dumps(fixture(path)) + "\n")
            print(target.relative_to(ROOT), target.stat().st_size, "bytes")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Counts random placements of a frame that `conddp reach` finds, and checks them by Pinocchio's kinematics.

    scripts/peers/setup
    build/peers/bin/python scripts/peers/reach_placements.py ur10.urdf:tool0 panda.urdf:panda_hand

Joint positions are drawn within the limits (at most a turn), so that every placement can be reached.
Prints for each robot the number of placements found with their rotations and without, and how many of
the answers are wrong by more than 1 µm.
"""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin

TOOL = Path(__file__).resolve().parents[2] / "build" / "release" / "bin" / "conddp"
COUNT = 60


def configuration(model, positions):
    """Pinocchio's configuration of joint positions by name; joints without limits have two numbers."""
    q = pin.neutral(model)
    for name, value in positions.items():
        joint = model.getJointId(name)
        at = model.idx_qs[joint]
        if model.nqs[joint] == 1:
            q[at] = value
        else:
            q[at:at + 2] = np.cos(value), np.sin(value)
    return q


def random_positions(model, random):
    positions = {}
    for joint in range(1, model.njoints):
        at = model.idx_qs[joint]
        low, high = -np.pi, np.pi
        if model.nqs[joint] == 1:
            low, high = max(model.lowerPositionLimit[at], low), min(model.upperPositionLimit[at], high)
        positions[model.names[joint]] = random.uniform(low, high)
    return positions


def placement(model, data, frame, positions):
    pin.framesForwardKinematics(model, data, configuration(model, positions))
    return data.oMf[model.getFrameId(frame)].copy()


def reach(urdf, frame, goal, with_rotation):
    """Joint positions by name, or None."""
    numbers = [str([float(x) for x in goal.translation])]
    if with_rotation:
        numbers += ["--rpy", str([float(x) for x in pin.rpy.matrixToRpy(goal.rotation)])]
    done = subprocess.run([TOOL, "reach", urdf, "--frame", frame, "--at", *numbers], capture_output=True, text=True)
    if done.returncode != 0:
        return None
    lines = [line.strip().rpartition(": ") for line in done.stdout.splitlines()[1:]]
    return {name.strip('"'): float(value) for name, _, value in lines}


def main():
    for robot in sys.argv[1:]:
        urdf, _, frame = robot.partition(":")
        model = pin.buildModelFromUrdf(urdf)
        data, random = model.createData(), np.random.default_rng(3)
        found, wrong = {True: 0, False: 0}, 0
        for _ in range(COUNT):
            goal = placement(model, data, frame, random_positions(model, random))
            for with_rotation in found:
                answer = reach(urdf, frame, goal, with_rotation)
                if answer is None:
                    continue
                found[with_rotation] += 1
                error = goal.actInv(placement(model, data, frame, answer))
                far = np.linalg.norm(error.translation)
                turned = np.linalg.norm(pin.log3(error.rotation)) if with_rotation else 0
                wrong += max(far, turned) > 1e-6
        print(f"{Path(urdf).name}: {found[True]} placements, {found[False]} positions of {COUNT}, {wrong} wrong")


if __name__ == "__main__":
    main()

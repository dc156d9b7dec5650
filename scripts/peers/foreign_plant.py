"""Prints where loops get to whose plant MuJoCo simulates: see scripts/peers/foreign_plant."""

import argparse
import csv
import json
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from conddp_tool import BINARIES, ROOT, expanded, output_of, settings

BRIDGE = ROOT / "build/peers/plant_bridge/plant_bridge"
#: Of the spheres that MuJoCo's feet touch by; the ground lies as much lower.
RADIUS = 0.005  # m

HEAD = """# Closed loops with MuJoCo as the plant

    scripts/peers/foreign_plant

A program with conddp's library controls a plant in another process, which sends the state. That process simulates the robot of
the same URDF file by MuJoCo, with MuJoCo's own soft contacts. `conddp mpc` runs the same loop for comparison. Neither is
disturbed nor delayed.

{own}; MuJoCo {version}.
"""


@dataclass
class Case:
    """A file with a section `mpc`, and settings of it for both plants."""
    title: str
    file: str
    overrides: tuple
    feet: tuple = ()      # links that touch the ground
    repeated: tuple = ()  # settings of the bridge, which knows no mpc.repeat


CASES = {
    "arm": Case("arm tracks a moving goal", "problems/mpc/arm_goal.yaml", ()),
    "quadruped": Case("quadruped trots forward", "problems/mpc/quadruped_commands.yaml",
                      ("gait.commands=[{at: 0, velocity: [0.3, 0, 0]}]",),
                      ("lf_foot", "rf_foot", "lh_foot", "rh_foot"), ("gait.cycles=16",)),
}


def loop_of(case):
    """The section mpc without disturbances, delay and what the bridge does not know."""
    loop = expanded(ROOT / case.file)["mpc"]
    kept = {key: loop[key] for key in ("horizon", "tick", "duration", "feedback")}
    plant = {"dt": loop["plant"]["dt"], "contacts": loop["plant"]["contacts"]}
    return {**kept, "plant": plant, "repeat": "gait" if case.feet else "hold"}


def own_loop(case, loop):
    """The states of conddp's plant: names of the columns, and a row a step."""
    with tempfile.TemporaryDirectory() as folder:
        output_of([BINARIES / "conddp", "mpc", ROOT / case.file, "--quiet", "-o", folder,
                   *settings((*case.overrides, "mpc=" + json.dumps(loop)))])
        with open(Path(folder) / "closed_loop.csv", encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
    columns = [name.split(" [")[0] for name in rows[0]]
    numbers = [[float(cell or "nan") for key, cell in row.items() if key != "phase"] for row in rows]
    columns.remove("phase")
    states = [i for i, name in enumerate(columns) if i > 0 and not name.startswith(("u/", "contact/"))]
    controls = [name for name in columns if name.startswith("u/")]
    return [columns[i] for i in states], controls, np.array(numbers)[:, states]


def urdf_of(case):
    """The robot's file with a free base and spheres at its feet, where it has some."""
    robot = expanded(ROOT / case.file)["robot"]
    tree = ElementTree.parse((ROOT / case.file).parent / robot["urdf"])
    root = tree.getroot()
    for link in root.iter("link"):
        if link.get("name") in case.feet:
            sphere = ElementTree.SubElement(link, "collision", name=link.get("name"))
            ElementTree.SubElement(ElementTree.SubElement(sphere, "geometry"), "sphere",
                                   radius=str(RADIUS))
    if robot.get("base") == "floating":
        children = {joint.find("child").get("link") for joint in root.iter("joint")}
        base = next(link.get("name") for link in root.iter("link") if link.get("name") not in children)
        ElementTree.SubElement(root, "link", name="world")
        joint = ElementTree.SubElement(root, "joint", name="base", type="floating")
        ElementTree.SubElement(joint, "parent", link="world")
        ElementTree.SubElement(joint, "child", link=base)
    return ElementTree.tostring(root, encoding="unicode")


class Plant:
    """MuJoCo's robot with the state and controls of conddp's columns."""

    def __init__(self, case, columns, controls, step):
        spec = mujoco.MjSpec.from_string(urdf_of(case))
        spec.option.timestep = step
        spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        if case.feet:
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], pos=[0, 0, -RADIUS],
                                    friction=[0.7, 0.005, 0.0001])
            for geom in spec.geoms:
                geom.friction = [0.7, 0.005, 0.0001]
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        joint = {name: self.model.joint(name.split("/")[1])
                 for name in columns if name.startswith("q/")}
        self.positions = {i: joint[name].qposadr[0] for i, name in enumerate(columns) if name in joint}
        self.velocities = {i: joint["q" + name[1:]].dofadr[0] for i, name in enumerate(columns)
                           if name.startswith("v/")}
        self.motors = [joint["q" + name[1:]].dofadr[0] for name in controls]
        self.columns, self.free = columns, "base/x" in columns

    def base(self, name):
        return self.columns.index("base/" + name)

    def rotation(self):
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, self.data.qpos[3:7])
        return rotation.reshape(3, 3)

    def take(self, x):
        """The state of conddp's columns as MuJoCo's."""
        for i, address in self.positions.items():
            self.data.qpos[address] = x[i]
        for i, address in self.velocities.items():
            self.data.qvel[address] = x[i]
        if self.free:
            self.data.qpos[:7] = [x[self.base(name)] for name in ("x", "y", "z", "qw", "qx", "qy", "qz")]
            self.data.qvel[:3] = self.rotation() @ [x[self.base(name)] for name in ("vx", "vy", "vz")]
            self.data.qvel[3:6] = [x[self.base(name)] for name in ("wx", "wy", "wz")]

    def state(self):
        """MuJoCo's state in conddp's columns. Linear velocities of a free base are those in its axes."""
        x = np.zeros(len(self.columns))
        for i, address in self.positions.items():
            x[i] = self.data.qpos[address]
        for i, address in self.velocities.items():
            x[i] = self.data.qvel[address]
        if self.free:
            for name, value in zip(("x", "y", "z", "qw", "qx", "qy", "qz"), self.data.qpos[:7]):
                x[self.base(name)] = value
            velocity = self.rotation().T @ self.data.qvel[:3]
            for name, value in zip(("vx", "vy", "vz", "wx", "wy", "wz"),
                                   (*velocity, *self.data.qvel[3:6])):
                x[self.base(name)] = value
        return x

    def step(self, u):
        self.data.qfrc_applied[self.motors] = u
        mujoco.mj_step(self.model, self.data)


def foreign_loop(case, loop, columns, controls, start):
    """The states of MuJoCo's plant, a row a step."""
    step = loop["plant"]["dt"]
    plant = Plant(case, columns, controls, step)
    plant.take(start)
    command = [BRIDGE, ROOT / case.file, loop["horizon"], loop["tick"], loop["feedback"]["rate"], step,
               *case.overrides, *case.repeated]
    rows = [start]
    with subprocess.Popen([str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          text=True) as bridge:
        for _ in range(round(loop["duration"] / step)):
            bridge.stdin.write(" ".join(repr(float(number)) for number in rows[-1]) + "\n")
            bridge.stdin.flush()
            plant.step([float(word) for word in bridge.stdout.readline().split()])
            rows.append(plant.state())
        bridge.stdin.close()
    return np.array(rows)


def row(name):
    """A row of the table."""
    case = CASES[name]
    loop = loop_of(case)
    columns, controls, own = own_loop(case, loop)
    foreign = foreign_loop(case, loop, columns, controls, own[0])
    if case.feet:
        places = [i for i, column in enumerate(columns) if column in ("base/x", "base/y", "base/z")]
        lowest = min(foreign[:, places[2]])
        figures = [f"base at ({', '.join(f'{rows[-1, i]:.2f}' for i in places)}) m" for rows in (foreign, own)]
        remark = f"the base is never below {lowest:.2f} m"
    else:
        joints = [i for i, column in enumerate(columns) if column.startswith("q/")]
        figures = [", ".join(f"{rows[-1, i]:.3f}" for i in joints) + " rad" for rows in (foreign, own)]
        apart = np.abs(foreign[:, joints] - own[:, joints]).max()
        remark = f"joints are never further apart than {apart:.1e} rad"
    return f"| {case.title} | {loop['duration']:g} s | {figures[0]} | {figures[1]} | {remark} |"


def main():
    parser = argparse.ArgumentParser(prog="scripts/peers/foreign_plant", description=(
        "Simulates closed loops with MuJoCo as the plant, and prints a table in Markdown."))
    parser.add_argument("--case", action="append", choices=list(CASES), help="only these cases")
    wanted = parser.parse_args()
    own = output_of([BINARIES / "conddp", "--version"]).splitlines()[0]
    print(HEAD.format(own=own, version=mujoco.__version__))
    print("| loop | lasts | ends with MuJoCo | ends with conddp's plant | meanwhile |\n|---|---|---|---|---|")
    for name in wanted.case or CASES:
        print(row(name), flush=True)


main()

"""What scripts/foreign_robots runs: tables of robots that conddp accepts and does not, of its
differences from Pinocchio, and of motions."""

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin

from robot_fixtures import random_configuration, to_pinocchio

ROOT = Path(__file__).resolve().parent.parent
BINARIES = ROOT / "build" / "release" / "bin"
ROBOTS = Path(sys.prefix).glob("lib/python3*/site-packages/cmeel.prefix/share/example-robot-data/robots")
TOLERANCE = 1e-9
STATES = 3

#: fixed base; part of the URDF's path: link that reaches, the last one by default
ARMS = {
    "kinova_description": "j2s6s200_end_effector", "panda_description/urdf/panda.urdf": "panda_hand_tcp",
    "so100": None, "so101": None, "talos_left_arm": None, "ur10_robot": "tool0", "ur3_robot": "tool0",
    "ur5_robot": "tool0", "xarm7": None, "z1_description": None, "baxter": "left_gripper",
}
#: floating base; part of the URDF's path: (SRDF beside it, its posture, feet, kind of contact)
LEGGED = {
    "a1_description": ("a1", "standing", ["FL_foot", "FR_foot", "RL_foot", "RR_foot"], "point"),
    "anymal_b_simple_description/robots/anymal.urdf": (
        "anymal", "standing", ["LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"], "point"),
    "anymal_c": ("anymal", "standing", ["LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"], "point"),
    "b1.urdf": ("b1", "standing", ["FL_foot", "FR_foot", "RL_foot", "RR_foot"], "point"),
    "go1.urdf": ("go1", "standing", ["FL_foot", "FR_foot", "RL_foot", "RR_foot"], "point"),
    "go2.urdf": ("go2", "standing", ["FL_foot", "FR_foot", "RL_foot", "RR_foot"], "point"),
    "hyq": ("hyq", "standing", ["lf_foot", "rf_foot", "lh_foot", "rh_foot"], "point"),
    "solo.urdf": ("solo", "standing", ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"], "point"),
    "solo12": ("solo", "standing", ["FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT"], "point"),
    "icub.urdf": ("icub", "half_sitting", ["l_sole", "r_sole"], "surface"),
    "icub_reduced": ("icub", "half_sitting", ["l_sole", "r_sole"], "surface"),
    "romeo.urdf": ("romeo", "half_sitting", ["l_ankle", "r_ankle"], "surface"),
    "romeo_small": ("romeo_small", "half_sitting", ["l_sole", "r_sole"], "surface"),
    "simple_humanoid.urdf": (
        "simple_humanoid", "half_sitting", ["l_ankle", "r_ankle"], "surface"),
    "talos_full_v2.urdf": ("talos", "half_sitting", ["left_sole_link", "right_sole_link"], "surface"),
    "talos_reduced.urdf": ("talos", "half_sitting", ["left_sole_link", "right_sole_link"], "surface"),
}

#: part of the URDF's path: directions in which the humanoid walks
WALKERS = {
    "icub.urdf": ["forward"], "icub_reduced": ["forward", "aside"], "romeo.urdf": ["forward"],
    "romeo_small": ["forward"], "simple_humanoid.urdf": ["forward", "aside"],
    "talos_full_v2.urdf": ["forward"], "talos_reduced.urdf": ["forward", "aside"],
}


def values(request):
    run = subprocess.run([BINARIES / "robot_values"], input=json.dumps(request), text=True,
                         capture_output=True, check=True)
    return json.loads(run.stdout)


def ways_out(text):
    """The joints that a message about missing inertia offers to lock, as {name: value}."""
    found = re.search(r"locked_joints: \{(.*?)\}", text)
    if not found:
        return None
    pairs = (entry.rsplit(": ", 1) for entry in found.group(1).split(", "))
    return {name: float(value) for name, value in pairs}


def pinocchio_model(urdf, base, locked):
    root = (pin.JointModelFreeFlyer(),) if base == "floating" else ()
    model = pin.buildModelFromUrdf(str(urdf), *root)
    if locked:
        q = pin.neutral(model)
        ids = [model.getJointId(name) for name in locked]
        for index, value in zip(ids, locked.values()):
            joint = model.joints[index]
            q[joint.idx_q:joint.idx_q + joint.nq] = value if joint.nq == 1 else (
                np.cos(value), np.sin(value))
        model = pin.buildReducedModel(model, ids, q)
    return model


def difference(urdf, base, locked):
    """The largest relative difference of each quantity over the states."""
    model = pinocchio_model(urdf, base, locked)
    data = model.createData()
    rng = np.random.default_rng(sum(map(ord, urdf.name)))
    states = [{"q": random_configuration(model, rng), "v": rng.normal(size=model.nv),
               "a": rng.normal(size=model.nv)} for _ in range(STATES)]
    ours = values({"urdf": str(urdf), "base": base, "locked_joints": locked,
                   "states": [{k: list(x) for k, x in s.items()} for s in states]})
    if model.nv == 0:
        return 0, {}
    names = list(model.names)[1:]
    if base == "floating":
        names[0] = ours["joints"][0]
    if names != ours["joints"]:
        raise ValueError("joints in another order")
    worst = {}
    for state, our in zip(states, ours["values"]):
        q = to_pinocchio(model, state["q"])
        v, a, n = state["v"], state["a"], model.nv
        M = np.triu(pin.crba(model, data, q)).T  # what crba fills
        theirs = {"M": M, "bias": pin.rnea(model, data, q, v, np.zeros(n)),
                  "tau": pin.rnea(model, data, q, v, a)}
        tau_q, tau_v, _ = pin.computeRNEADerivatives(model, data, q, v, a)
        theirs |= {"tau_q": tau_q.copy(), "tau_v": tau_v.copy()}
        for key, expected in theirs.items():
            got = np.array(our[key])
            if expected.ndim == 2:
                got = got.reshape(n, n).T
                got = np.tril(got) if key == "M" else got
            scale = max(np.abs(expected).max(), 1e-6 * np.abs(M).max())
            worst[key] = max(worst.get(key, 0), np.abs(got - expected).max() / scale)
    return model.nv, worst


def solve(problem, folder, limit=60):
    """(solution, "") or (None, error). A robot whose warning advises to lock joints gets them locked
    where it fails with them, and the second text says so."""
    file = folder / "problem.yaml"
    file.write_text(json.dumps(problem, indent=1))
    out = folder / "out"
    run = subprocess.run([BINARIES / "conddp", "solve", file, "-o", out, "--max-time", str(limit)],
                         capture_output=True, text=True)
    if not (out / "solution.json").exists():
        lines = [line for line in run.stderr.splitlines() if "error" in line]
        return None, (lines or [run.stderr])[0]
    solution = json.loads((out / "solution.json").read_text())
    advised = ways_out(run.stderr)
    robot = problem["robot"]
    if solution["status"] == "converged" or not advised or robot.get("locked_joints"):
        return solution, ""
    robot["locked_joints"] = advised
    for configuration in robot["configurations"].values():
        for joint in advised:
            configuration["joints"].pop(joint, None)
    solution, _ = solve(problem, folder, limit)
    return solution, f"with {', '.join(advised)} locked, as a warning advises: "


def posture(model, q):
    """Joints of one number, by name."""
    return {name: float(q[joint.idx_q]) for name, joint in zip(model.names[1:], model.joints[1:])
            if joint.nq == 1}


def reach(urdf, link, folder):
    model = pin.buildModelFromUrdf(str(urdf))
    finite = np.isfinite(model.lowerPositionLimit) & np.isfinite(model.upperPositionLimit)
    finite &= np.abs(model.upperPositionLimit) < 1e3
    middle = np.where(finite, (model.lowerPositionLimit + model.upperPositionLimit) / 2, 0)
    start = pin.neutral(model)
    goal = pin.neutral(model)
    for joint in model.joints[1:]:
        if joint.nq != 1:
            continue
        i = joint.idx_q
        room = model.upperPositionLimit[i] - model.lowerPositionLimit[i] if finite[i] else 2
        start[i] = middle[i] if abs(middle[i]) > 1e-12 else 0.0
        goal[i] = start[i] + min(0.3, 0.2 * room)
    if link is None:
        moving = [f.name for f in model.frames if f.type == pin.FrameType.BODY and f.parentJoint > 0]
        link = moving[-1]
    data = model.createData()
    pin.framesForwardKinematics(model, data, goal)
    target = data.oMf[model.getFrameId(link)].translation
    pin.framesForwardKinematics(model, data, start)
    begin = data.oMf[model.getFrameId(link)].translation.copy()
    pin.framesForwardKinematics(model, data, goal)
    problem = {
        "conddp": 1, "name": "reach",
        "robot": {"urdf": str(urdf), "configurations": {"start": {"joints": posture(model, start)}}},
        "initial_state": {"configuration": "start"},
        "phases": [{"name": "reach", "knots": 50, "dt": 0.02}],
        "costs": {"posture": {"residual": "state", "reference": "start", "weight": 0.1},
                  "effort": {"residual": "control_gravity", "weight": 1e-3}},
        "terminal": {"costs": {
            "hand": {"residual": "frame_position", "frame": link,
                     "reference": [float(x) for x in target], "weight": 1e5},
            "rest": {"residual": "joint_velocity", "weight": 10}}},
        "initial_guess": {"states": "initial", "controls": "quasi_static"},
    }
    solution, error = solve(problem, folder)
    if solution is None:
        return False, error
    moved = np.linalg.norm(data.oMf[model.getFrameId(link)].translation - begin)
    q = final_configuration(solution, model)
    pin.framesForwardKinematics(model, data, q)
    missed = np.linalg.norm(data.oMf[model.getFrameId(link)].translation - target)
    text = (f"{solution['status']} in {solution['iterations']} iterations; {link} goes "
            f"{moved * 100:.0f} cm, {missed * 1000:.2f} mm from the goal")
    return solution["status"] == "converged" and missed < 0.01, text


def final_configuration(solution, model):
    return to_pinocchio(model, np.array(solution["trajectory"]["x"][-1][:count_q(model)]))


def count_q(model):
    return sum(7 if j.nq == 7 else j.nv for j in model.joints[1:])


def srdf_beside(urdf, name):
    for folder in urdf.parents:
        found = list(folder.glob(f"srdf/{name}.srdf"))
        if found:
            return found[0]
        if folder.name == "robots" and folder.parent.name == "example-robot-data":
            break
    found = sorted(urdf.parents[2].glob(f"*/srdf/{name}.srdf"))
    return found[0]


def posed(urdf, spec):
    """The robot on a floating base in the posture of its SRDF, its frames' places computed."""
    srdf, name = spec[:2]
    model = pin.buildModelFromUrdf(str(urdf), pin.JointModelFreeFlyer())
    pin.loadReferenceConfigurations(model, str(srdf_beside(urdf, srdf)), False)
    q = model.referenceConfigurations[name].copy()
    data = model.createData()
    pin.framesForwardKinematics(model, data, q)
    return model, data, q


def stand(urdf, spec, locked, folder):
    model, data, q = posed(urdf, spec)
    feet, kind = spec[2:]
    base = [float(x) for x in q[:7]]
    joints = {joint: value for joint, value in posture(model, q).items() if joint not in locked}
    standing = {"base": {"position": base[:3], "orientation": base[3:]}, "joints": joints}
    weight = 9.81 * sum(inertia.mass for inertia in model.inertias)
    problem = {
        "conddp": 1, "name": "stand",
        "robot": {"urdf": str(urdf), "base": "floating", "locked_joints": locked,
                  "configurations": {"standing": standing}},
        "contacts": {"defaults": {"type": kind, "friction": 0.7, "baumgarte": {"kp": 0, "kd": 30}},
                     **{foot: {"frame": foot} for foot in feet}},
        "initial_state": {"configuration": "standing"},
        "phases": [{"name": "stand", "knots": 50, "dt": 0.02, "contacts": "all"}],
        "costs": {"posture": {"residual": "state", "reference": "standing", "weight": 10},
                  "effort": {"residual": "control", "weight": 1e-4 / max(weight / 100, 1)}},
        "terminal": {"costs": {"stand": {"residual": "state", "reference": "standing", "weight": 100}}},
        "initial_guess": {"states": "initial", "controls": "quasi_static"},
    }
    solution, text = solve(problem, folder)
    if solution is None:
        return False, text
    first, last = (np.array(solution["trajectory"]["x"][k][:3]) for k in (0, -1))
    sunk = np.abs(last - first).max()
    text += (f"{solution['status']} in {solution['iterations']} iterations; the base ends "
            f"{sunk * 1000:.1f} mm from where it began")
    return solution["status"] == "converged" and sunk < 0.1, text


def walk(urdf, spec, locked, direction, folder):
    """Three steps of a third of the hips' height in all, as problems/biped_steps.yaml takes them."""
    model, data, q = posed(urdf, spec)
    feet, kind = spec[2:]
    soles = [data.oMf[model.getFrameId(foot)].translation for foot in feet]
    height = q[2] - soles[0][2]
    left, right = feet if soles[0][1] > soles[1][1] else feet[::-1]
    step = 0.17 * height
    one = [step, 0, 0] if direction == "forward" else [0, step / 2, 0]
    two = [2 * x for x in one]
    joints = {joint: value for joint, value in posture(model, q).items() if joint not in locked}

    def standing(shift):
        position = [float(a + b) for a, b in zip(q[:3], shift)]
        return {"base": {"position": position, "orientation": [float(x) for x in q[3:7]]},
                "joints": joints}

    # A step aside of the left foot is followed by one of the right foot as long, twice.
    steps = [(left, right, one), (right, left, two if direction == "forward" else one),
             (left, right, one)]
    if direction == "aside":
        steps.append((right, left, one))
    phases, swings = [{"name": "shift", "knots": 20, "dt": 0.02, "contacts": "all"}], {}
    for i, (foot, stance, length) in enumerate(steps):
        phases.append({"name": f"step_{i}", "knots": 20, "dt": 0.02, "contacts": [stance]})
        phases.append({"name": f"double_{i}", "knots": 5 if i + 1 < len(steps) else 25, "dt": 0.02,
                       "contacts": "all"})
        swings[f"swing_{i}"] = {
            "residual": "frame_placement", "frame": foot, "phases": f"step_{i}", "weight": 1e4,
            "swing": {"height": 0.07 * height, "step": [float(x) for x in length]}}
    problem = {
        "conddp": 1, "name": "walk",
        "robot": {"urdf": str(urdf), "base": "floating", "locked_joints": locked,
                  "configurations": {"standing": standing([0, 0, 0]), "arrived": standing(two)}},
        "contacts": {"defaults": {"type": kind, "size": [0.16 * height / 0.6, 0.07 * height / 0.6],
                                  "friction": 0.7},
                     **{foot: {"frame": foot} for foot in feet}},
        "initial_state": {"configuration": "standing"},
        "phases": phases,
        "costs": {
            "posture": {"residual": "state", "reference": "standing", "weight": 10,
                        "weights": {"base/x": 0, "base/y": 0.1 if direction == "forward" else 0,
                                    "base/z": 10, "base/r*": 10,
                                    "q/*": 0.5, "base/v*": 0.1, "base/w*": 0.1, "v/*": 0.02}},
            "effort": {"residual": "control", "weight": 1e-3},
            "cone": {"residual": "wrench_cone", "contacts": "all", "safety": 0.85, "weight": 10},
            **swings},
        "terminal": {"costs": {"arrive": {"residual": "state", "reference": "arrived",
                                          "weight": 100}}},
        "initial_guess": {"states": "initial", "controls": "quasi_static"},
    }
    solution, text = solve(problem, folder)
    if solution is None:
        return False, text
    x = np.array(solution["trajectory"]["x"])
    text += (f"{solution['status']} in {solution['iterations']} iterations; the base goes "
            f"{np.linalg.norm(x[-1, :2] - x[0, :2]) * 100:.0f} of "
            f"{np.linalg.norm(two) * 100:.0f} cm")
    kinds = {}
    for finding in solution["findings"]:
        kinds.setdefault(finding["kind"], finding)
    for finding in kinds.values():
        text += f"\n      {finding['message']}"
    return solution["status"] == "converged", text


def entry_of(table, path):
    return next((key for key in table if key in path), None)


def main():
    arguments = sys.argv[1:]
    motions = "--no-motions" not in arguments
    wanted = [name for name in arguments if not name.startswith("--")]
    root = next(ROBOTS)
    urdfs = [u for u in sorted(root.rglob("*.urdf"))
             if not wanted or any(name in str(u.relative_to(root)) for name in wanted)]
    failed = 0
    rejected = []
    print(f"{'robot':<60}{'base':<10}{'DoF':>4}  {'M':>8}{'bias':>9}{'tau_q':>9}{'tau_v':>9}")
    usable = {}
    for urdf in urdfs:
        path = str(urdf.relative_to(root))
        for base in ("fixed", "floating"):
            locked = {}
            answer = values({"urdf": str(urdf), "base": base, "states": []})
            if "errors" in answer:
                message, locked = answer["errors"][0]["message"], ways_out(answer["errors"][0]["hint"])
                rejected.append((path, base, message, bool(locked)))
                if not locked:
                    continue
            nv, worst = difference(urdf, base, locked)
            usable[path, base] = locked
            wrong = max(worst.values(), default=0) > TOLERANCE
            failed += wrong
            print(f"{path:<60}{base:<10}{nv:>4}  " +
                  "".join(f"{worst[k]:9.1e}" for k in ("M", "bias", "tau_q", "tau_v") if worst) +
                  (f"  ({len(locked)} joints locked)" if locked else "") +
                  ("  DIFFERS" if wrong else ""))
    print("\nnot accepted as they are:")
    for path, base, message, lockable in rejected:
        print(f"  {path} ({base}): {message}" + ("; accepted with the joints locked" * lockable))
    if motions:
        print("\nmotions:")
        for urdf in urdfs:
            path = str(urdf.relative_to(root))
            arm, legs = entry_of(ARMS, path), entry_of(LEGGED, path)
            with tempfile.TemporaryDirectory() as folder:
                if arm and (path, "fixed") in usable:
                    good, text = reach(urdf, ARMS[arm], Path(folder))
                elif legs and (path, "floating") in usable:
                    good, text = stand(urdf, LEGGED[legs], usable[path, "floating"], Path(folder))
                else:
                    continue
            failed += not good
            print(f"  {path}: {'' if good else 'FAILS: '}{text}", flush=True)
        print("\nwalks:")
        for urdf in urdfs:
            path = str(urdf.relative_to(root))
            walker = entry_of(WALKERS, path)
            if not walker or (path, "floating") not in usable:
                continue
            for direction in WALKERS[walker]:
                with tempfile.TemporaryDirectory() as folder:
                    good, text = walk(urdf, LEGGED[entry_of(LEGGED, path)],
                                      usable[path, "floating"], direction, Path(folder))
                failed += not good
                print(f"  {path}, {direction}: {'' if good else 'FAILS: '}{text}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

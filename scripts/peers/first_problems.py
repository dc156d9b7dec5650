"""Prints, as Markdown, for how many robots of Python packages a first problem solves as it is.

    pip install mujoco gymnasium dm_control example-robot-data && pip install --no-deps robosuite
    scripts/build release conddp conddp_python
    PYTHONPATH=build/release/python python scripts/peers/first_problems.py [--list] [NAME...]

Robots of MJCF files are written as URDF by `conddp.from_mjcf`. For each URDF `conddp init` writes a
problem without an option, and `conddp solve` solves it. NAME takes the robots whose path has this text.
"""

import argparse
import collections
import importlib.metadata
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import warnings
from pathlib import Path

import mujoco

import conddp
from conddp_tool import BINARIES, output_of, settings

#: Folders of packages with robots.
MJCF = {
    "dm_control": ["suite", "mujoco/testing/assets", "locomotion/walkers/assets", "third_party"],
    "gymnasium": ["envs/mujoco/assets"],
    "robosuite": ["models/assets/robots"],
}
URDF = "cmeel.prefix/share/example-robot-data/robots"
#: Longest time of a solve, s.
PATIENCE = 120
#: Keys of a robot that an MJCF file gives and that a URDF, which `init` reads, does not.
OWN_KEYS = ("rotor_inertia", "passive")

SOLVED = "solved"

HEAD = """# First problems

    PYTHONPATH=build/release/python python scripts/peers/first_problems.py

`conddp init` writes a first problem for a robot, without an option. *Solved* are those that `conddp solve` ends with a certified
local minimum, without an edit; *stationary* answers converged, too, but rounding leaves no curvature. Robots are those of Python
packages: MJCF files, which `conddp.from_mjcf` writes as URDF, and URDFs. *With rotors* are the same problems with rotor inertia and
damping of the MJCF file, which `from_mjcf` returns and `init` does not read. Solves end after {patience} s.

{own}; {versions}.
"""


def mjcf_files():
    """(package, its folder, file) of every MJCF file that MuJoCo compiles and that has joints."""
    found = []
    for package, folders in MJCF.items():
        spec = importlib.util.find_spec(package)
        for folder in [Path(spec.origin).parent / name for name in folders] if spec else []:
            for file in sorted(folder.rglob("*.xml")):
                try:
                    model = mujoco.MjModel.from_xml_path(str(file))
                except ValueError:  # a part that others include
                    continue
                if model.nv > 0:
                    found.append((package, folder, file))
    return found


def urdf_files():
    folders = [Path(place) / URDF for place in sys.path]
    return [("example-robot-data", folder, file)
            for folder in folders for file in sorted(folder.rglob("*.urdf"))]


def largest_body(file):
    """Of the bodies in the world: the one that most degrees of freedom hang on."""
    model = mujoco.MjModel.from_xml_path(str(file))
    counts = collections.Counter(int(root) for root in model.body_rootid[model.dof_bodyid])
    return model.body(counts.most_common(1)[0][0]).name


def robot_of(file, folder):
    """The key `robot` of a problem."""
    if file.suffix == ".urdf":
        return {"urdf": str(file)}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return conddp.from_mjcf(file, folder)
        except ValueError as error:
            if "choose one" not in str(error):
                raise
        return conddp.from_mjcf(file, folder, body=largest_body(file))


def run(words, folder):
    return subprocess.run([str(word) for word in words], cwd=folder, capture_output=True, text=True,
                          timeout=PATIENCE)


def first_error(text):
    lines = [line for line in text.splitlines() if "error: " in line] or text.splitlines() or [""]
    return lines[0].split("error: ")[-1].strip()


def solve(folder, overrides=()):
    """SOLVED or a reason."""
    try:
        ended = run([BINARIES / "conddp", "solve", "first.yaml", "-o", "out", *settings(overrides)],
                    folder)
    except subprocess.TimeoutExpired:
        return f"longer than {PATIENCE} s"
    file = folder / "out/solution.json"
    if not file.exists():
        return first_error(ended.stderr)
    solution = json.loads(file.read_text(encoding="utf-8"))
    file.unlink()
    verdict = solution.get("certificate", {}).get("verdict", "not verified")
    if ended.returncode == 0 and solution["status"] == "converged" and verdict == "local_minimum":
        return SOLVED
    return f"{solution['status']}, {verdict}"


def outcome(file, folder):
    """How far a robot gets: (step, reason, the reason with its own keys)."""
    try:
        robot = robot_of(file, folder)
    except ValueError as error:
        return "not read", str(error), ""
    start = run([BINARIES / "conddp", "init", robot["urdf"], "-o", "first.yaml"], folder)
    if start.returncode != 0:
        return "no first problem", first_error(start.stderr), ""
    own = tuple(f"robot.{key}={json.dumps(robot[key])}" for key in OWN_KEYS if key in robot)
    return "first problem", solve(folder), solve(folder, own) if own else ""


def share(count, whole):
    return f"{count} ({count / whole:.0%})" if whole else "–"


def printed(results):
    """The table of packages, and that of reasons with their robots."""
    counts, reasons = collections.defaultdict(collections.Counter), collections.defaultdict(list)
    for package, name, step, reason, with_rotors in results:
        counts[package].update(["robots", step])
        counts[package]["solved"] += reason == SOLVED
        counts[package]["with rotors"] += with_rotors == SOLVED
        if step != "first problem":
            reasons[step, ""].append(f"`{name}` ({reason})")
        elif reason != SOLVED or with_rotors not in ("", SOLVED):
            reasons[reason, with_rotors].append(f"`{name}`")
    mjcf = sum((counts[package] for package in counts if package in MJCF), collections.Counter())
    counts = {**{name: counts[name] for name in counts if name in MJCF}, "MJCF in all": mjcf, **counts}
    print("| package | robots | read | first problem | solved, of those read | with rotors |")
    print("|---|---|---|---|---|---|")
    for package, own in counts.items():
        read = own["robots"] - own["not read"]
        rotors = "–" if package == "example-robot-data" else own["with rotors"]
        print(f"| {package} | {own['robots']} | {read} | {own['first problem']} "
              f"| {share(own['solved'], read)} | {rotors} |")
    print("\n| not solved | with rotors | robots |\n|---|---|---|")
    for (reason, with_rotors), names in reasons.items():
        print(f"| {reason} | {with_rotors} | {', '.join(names)} |")


def versions():
    packages = (*MJCF, "example-robot-data", "mujoco")
    installed = {own.metadata["Name"]: own.version for own in importlib.metadata.distributions()}
    return ", ".join(f"{name} {installed[name]}" for name in packages if name in installed)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--list", action="store_true", help="print every robot meanwhile, on stderr")
    parser.add_argument("names", nargs="*", metavar="NAME")
    wanted = parser.parse_args()
    own = output_of([BINARIES / "conddp", "--version"]).splitlines()[0].strip()
    results = []
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)  # MuJoCo writes its log into the working folder
        for package, home, file in mjcf_files() + urdf_files():
            name = str(file.relative_to(home))
            if wanted.names and not any(text in str(file) for text in wanted.names):
                continue
            with tempfile.TemporaryDirectory() as folder:
                results.append((package, name, *outcome(file, Path(folder))))
            if wanted.list:
                print(*results[-1], sep="\t", file=sys.stderr, flush=True)
    print(HEAD.format(patience=PATIENCE, own=own, versions=versions()))
    printed(results)


if __name__ == "__main__":
    main()

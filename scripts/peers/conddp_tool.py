"""The tool and its benchmark as processes: what they say of a problem, as Python objects."""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BINARIES = Path(os.environ.get("CONDDP_BINARIES", ROOT / "build/release/bin"))
PEERS = ROOT / "build/peers"
NATIVE = PEERS / "native"


class Untranslatable(Exception):
    """Something in a problem that a peer does not have, by name."""


def is_loaded(library):
    """Whether a peer is compiled for this machine: its library is in this process."""
    with open("/proc/self/maps", encoding="utf-8") as lines:
        return any(line.rstrip().endswith(str(library)) for line in lines)


def parsed(parser, robots):
    """Arguments of a comparison with Crocoddyl: those of the parser, where robots are, and how the peers
    were built. Ends the script where natively built ones are wanted and are not loaded."""
    parser.add_argument("--robots", default=os.environ.get("CONDDP_ROBOTS_DIR", ""),
                        help=f"folder with {robots} (by default CONDDP_ROBOTS_DIR)")
    parser.add_argument("--native", action="store_true",
                        help="Crocoddyl and Pinocchio compiled for this machine")
    wanted = parser.parse_args()
    library = NATIVE / "libcrocoddyl_native.so"
    if wanted.native and not is_loaded(library):
        sys.exit(f"{parser.prog}: --native: {library.relative_to(ROOT)} is not loaded")
    return wanted


def output_of(command):
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if result.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(map(str, command))}: {result.stderr.strip()}")
    return result.stdout


def settings(overrides):
    return [word for override in overrides for word in ("--set", override)]


def robot_settings(file, folder):
    """Where the robots of files that are not part of the product are."""
    if "tests/foreign" not in str(file):
        return ()
    with open(ROOT / file, encoding="utf-8") as lines:
        urdf = next(line.split("/")[-1].strip() for line in lines if "urdf:" in line)
    path = os.path.join(os.path.abspath(folder), urdf)
    if not os.path.exists(path):
        raise Untranslatable(f"there is no {path}: name its folder with --robots")
    return (f"robot.urdf={path}",)


def expanded(file, overrides=()):
    """The problem file with every default filled in; its URDF as an absolute path."""
    command = [BINARIES / "conddp", "check", file, "--expand", "--json", *settings(overrides)]
    problem = json.loads(output_of(command))
    if "robot" in problem:
        urdf = Path(file).resolve().parent / problem["robot"]["urdf"]
        problem["robot"]["urdf"] = str(urdf.resolve())
    return problem


def columns(file, overrides=()):
    """The names of states and controls."""
    found = json.loads(output_of([BINARIES / "conddp", "check", file, "--json", *settings(overrides)]))
    return found["state"]["columns"], found["control"]["columns"]


def solve_times(file, solver, repeat, overrides=(), drop=()):
    """Guess, answer and timed runs of one of our solvers."""
    drops = [word for name in drop for word in ("--drop", name)]
    command = [BINARIES / "bench_solve_times", file, "--solver", solver, "--repeat", repeat,
               *settings(overrides), *drops]
    return json.loads(output_of(command))

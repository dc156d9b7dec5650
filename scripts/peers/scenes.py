#!/usr/bin/env python3
"""Scenes of conddp and the gaits of Crocoddyl's own problem builders: lines, knots, iterations and seconds.

    scripts/peers/setup
    build/peers/bin/python scripts/peers/scenes.py             # tables of docs/measurements/peers.md
    build/peers/bin/python scripts/peers/scenes.py FILE...     # lines of Python files and notebooks

Lines are those of code: without empty ones, comments and texts that document. Everything runs with one
thread. Seconds of conddp include the certificate; those of Crocoddyl are of solve() alone.
"""

import ast
import io
import json
import subprocess
import sys
import tempfile
import time
import tokenize
from pathlib import Path

from conddp_tool import BINARIES, ROOT

SCENES = ("arm_shelf", "quadruped_stairs", "quadruped_hills", "biped_stairs", "two_arms", "five_bar_jump",
          "grasp_carry", "hexapod_tripod", "trailer_parking")
FEET_OF_ANYMAL = ("LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT")
FEET_OF_TALOS = ("right_sole_link", "left_sole_link")
# The numbers of Crocoddyl 3.2.1, examples/quadrupedal_gaits_fwddyn.py and bipedal_gaits_fwddyn.py.
ANYMAL_GAITS = (("Walking", (0.25, 0.15, 1e-2, 25, 2)), ("Trotting", (0.15, 0.1, 1e-2, 25, 2)),
                ("Pacing", (0.15, 0.1, 1e-2, 25, 5)), ("Bounding", (0.15, 0.1, 1e-2, 25, 5)),
                ("Jumping", (0.15, [0.0, 0.3, 0.0], 1e-2, 10, 20)))
TALOS_GAITS = (("Walking", (0.6, 0.1, 0.03, 15, 4)), ("Jumping", (0.1, [0.0, 0.3, 0.0], 0.03, 9, 6)),
               ("Walking", (0.6, 0.1, 0.03, 15, 2)))


def code_lines(text):
    """Number of lines with code in a Python text."""
    empty = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT,
             tokenize.ENDMARKER)
    lines = {line for token in tokenize.generate_tokens(io.StringIO(text).readline)
             if token.type not in empty for line in range(token.start[0], token.end[0] + 1)}
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            lines -= set(range(node.body[0].lineno, node.body[0].end_lineno + 1))
    return len(lines)


def notebook_lines(text):
    """Number of lines with code in the cells of a notebook."""
    cells = ("".join(cell["source"]) for cell in json.loads(text)["cells"] if cell["cell_type"] == "code")
    return sum(1 for cell in cells for line in cell.split("\n") if line.strip() and line.strip()[0] not in "#%!")


def show_lines(files):
    for file in map(Path, files):
        count = notebook_lines if file.suffix == ".ipynb" else code_lines
        print(f"{file.name}: {count(file.read_text(encoding='utf-8'))} lines")


def show_scene(name, out):
    file = ROOT / "problems" / f"{name}.yaml"
    lines = sum(1 for line in file.read_text(encoding="utf-8").split("\n") if line.strip() and line.strip()[0] != "#")
    subprocess.run([BINARIES / "conddp", "solve", file, "--threads", "1", "-o", out], check=True,
                   capture_output=True)
    answer = json.loads((Path(out) / "solution.json").read_text(encoding="utf-8"))
    print(f"| `{name}` | {lines} | {len(answer['trajectory']['t']) - 1} | {answer['iterations']} "
          f"| {answer['time_s']['total']:.2f} |")


def show_gaits(title, gaits, builder, x0):
    import crocoddyl

    rows = []
    for kind, numbers in gaits:
        solver = crocoddyl.SolverFDDP(getattr(builder, f"create{kind}Problem")(x0, *numbers))
        states = [x0] * (solver.problem.T + 1)
        controls = solver.problem.quasiStatic(states[:-1])
        began = time.process_time()
        converged = solver.solve(states, controls, 100, False)
        rows.append((kind.lower(), solver.problem.T, solver.iter if converged else "-",
                     f"{time.process_time() - began:.2f}"))
        x0 = solver.xs[-1]
    print(f"| {title}:", " | ".join(", ".join(str(row[i]) for row in rows) for i in range(4)), "|")


def main():
    if len(sys.argv) > 1:
        return show_lines(sys.argv[1:])
    import example_robot_data
    import numpy as np
    from crocoddyl.utils import biped, quadruped

    with tempfile.TemporaryDirectory() as out:
        for name in SCENES:
            show_scene(name, out)
    for title, robot, pose, make, feet, gaits in (
            ("ANYmal", "anymal", "standing", quadruped.SimpleQuadrupedalGaitProblem, FEET_OF_ANYMAL, ANYMAL_GAITS),
            ("legs of Talos", "talos_legs", "half_sitting", biped.SimpleBipedGaitProblem, FEET_OF_TALOS, TALOS_GAITS)):
        model = example_robot_data.load(robot).model
        x0 = np.concatenate([model.referenceConfigurations[pose], np.zeros(model.nv)])
        show_gaits(title, gaits, make(model, *feet), x0)
    show_lines([quadruped.__file__, biped.__file__])


if __name__ == "__main__":
    main()

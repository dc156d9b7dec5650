"""The package under a strict type checker, with the stubs of the compiled module."""

import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("mypy")

PACKAGE = pathlib.Path(__file__).parents[1] / "conddp"

USE = """
import conddp
import numpy
problem = conddp.load("reach.yaml")
answer = problem.solve("box_fddp", warm_start=problem.solve(), max_iterations=50)
final: numpy.ndarray = answer.x[-1]
page: str = answer.report()
reveal_type(conddp.Mpc(problem).tick(0.0, final))
answer.cost = "low"
problem.solve(guess=1)
answer.report(file=3.0)
"""


def checked(path, folder):
    run = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", folder / "cache", path]
    ended = subprocess.run(
        run, cwd=folder, capture_output=True, text=True, env={"MYPYPATH": str(PACKAGE.parent)}
    )
    return ended.stdout


def test_package_is_typed(tmp_path):
    assert "Success: no issues" in checked(PACKAGE, tmp_path)


def test_misuse_is_found(tmp_path):
    (tmp_path / "use.py").write_text(USE)
    found = checked("use.py", tmp_path).splitlines()
    assert "ndarray" in found[0] and "use.py:8" in found[0]
    assert {line.split(":")[1] for line in found if "error:" in line} == {"9", "10", "11"}

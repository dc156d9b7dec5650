"""Recipes of docs/python.md with other packages, as they stand, after those that need NumPy alone."""

import pathlib
import re
import shutil
import subprocess

import pytest

conddp = pytest.importorskip("conddp")

ROOT = pathlib.Path(__file__).parents[2]
TEXT = (ROOT / "docs" / "python.md").read_text()
BLOCKS = re.findall(r"\n### ([^\n]*)\n(?:(?!\n### ).)*?\n```py\n(.*?)```", TEXT, re.DOTALL)
PACKAGES = "crocoddyl gymnasium h5py mcap_ros2 mujoco pinocchio rerun torch".split()
PLAN = """conddp_batch: 1
problem: {problem}
vary:
  x: {{key: terminal.costs.tool.reference.position.0, linspace: [0.35, 0.5, 3]}}
  knots: {{key: phases.reach.knots, values: [20, 35]}}
"""


def tool():
    built = ROOT / "build/release/bin/conddp"
    return str(built) if built.exists() else shutil.which("conddp")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where recipes run: with the example problems, and the data set of a batch."""
    folder = tmp_path_factory.mktemp("recipes")
    (folder / "problems").symlink_to(ROOT / "problems")
    (folder / "plan.yaml").write_text(PLAN.format(problem=ROOT / "problems/arm_reach.yaml"))
    run = [tool(), "batch", "run", "plan.yaml", "-o", "out/reach", "-j", "1"]
    subprocess.run(run, cwd=folder, check=True, capture_output=True)
    return folder


@pytest.fixture(scope="module")
def names():
    return {}


def test_recipes_are_found():
    assert len(BLOCKS) == TEXT.count("```py\n") >= 5


@pytest.mark.parametrize("block", ["start", *[title for title, _ in BLOCKS]])
def test_recipe(block, folder, names, monkeypatch):
    monkeypatch.chdir(folder)
    code = dict(BLOCKS).get(block) or "import conddp, numpy\n"
    try:
        exec(compile(code, f"docs/python.md: {block}", "exec"), names)
    except ImportError as error:
        if error.name not in PACKAGES:
            raise
        pytest.skip(str(error))
    except NameError as error:  # the recipe before was left out
        if error.name not in ("balance", "file"):
            raise
        pytest.skip(str(error))
    if "batches" in names and block.endswith("torch"):
        inputs, controls = next(iter(names["batches"]))
        assert inputs.shape == (32, 14 + 2) and controls.shape == (32, 7)
        assert not inputs.isnan().any() and not controls.isnan().any()

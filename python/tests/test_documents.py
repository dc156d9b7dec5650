"""The recipes of docs/python.md run as they stand, one after the other."""

import pathlib
import re

ROOT = pathlib.Path(__file__).parents[2]


def test_recipes(tmp_path, monkeypatch):
    text = (ROOT / "docs" / "python.md").read_text()
    (tmp_path / "problems").symlink_to(ROOT / "problems")
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) >= 8
    names = {}
    for block in blocks:
        exec(compile(block, "docs/python.md", "exec"), names)

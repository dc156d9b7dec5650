"""The command `conddp` of the wheel: the tool beside this package."""

import os
import sys


def main() -> None:
    """Becomes the tool, with the arguments of this process."""
    tool = os.path.join(os.path.dirname(os.path.abspath(__file__)), "tool", "bin", "conddp")
    os.execv(tool, [tool, *sys.argv[1:]])

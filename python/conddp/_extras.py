"""Packages that only some functions need."""

import importlib
from typing import Any


def needed(package: str, extra: str, purpose: str) -> Any:
    """Imports a package; without it, the error names the extra of conddp that installs it."""
    try:
        return importlib.import_module(package)
    except ImportError as error:
        raise ImportError(
            f"{purpose} needs the package {package.split('.')[0]}: pip install 'conddp[{extra}]' "
            f"({error})",
            name=error.name,
        ) from error

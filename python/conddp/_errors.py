"""Exceptions of conddp."""

from typing import Any, Dict, Iterable, List


class ProblemError(ValueError):
    """A problem that cannot be built. The text shows the places and what would be accepted.

    errors: a dictionary for each error, with message, hint, key, file, line, column and accepted.
    """

    def __init__(self, text: str, errors: Iterable[Dict[str, Any]] = ()):
        super().__init__(text.strip())
        self.errors: List[Dict[str, Any]] = list(errors)

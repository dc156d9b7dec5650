"""Mutations drawn by a seed from the sources of some layers."""

import dataclasses
import pathlib
import random

from mutation.places import Mutation, find_places


@dataclasses.dataclass(frozen=True)
class Mutant:
    number: int  # what the environment variable selects
    layer: str
    file: str    # relative to the tree
    line: int
    mutation: Mutation
    original: str  # the lines concerned, blanks at their ends removed
    mutated: str

    def describe(self):
        return (f"{self.file}:{self.line}: {self.mutation.kind} (mutant {self.number})\n"
                f"    - {self.original}\n    + {self.mutated}")


def make_mutant(number, layer, file, text, mutation):
    first = text.rfind("\n", 0, mutation.start) + 1
    last = text.find("\n", mutation.end)

    def tidy(lines):
        return " ".join(lines.split())

    return Mutant(number, layer, file, text.count("\n", 0, mutation.start) + 1, mutation,
                  tidy(text[first:last]),
                  tidy(text[first:mutation.start] + mutation.replacement + text[mutation.end:last]))


def draw(tree, layers, seed):
    """All mutants in the order in which a seed draws them: of each place one."""
    chance = random.Random(seed)
    found = []
    for layer in layers:
        for path in sorted((tree / "src" / layer).rglob("*.[ch]pp")):
            text = path.read_text(encoding="utf-8")
            file = str(path.relative_to(tree))
            found += [(layer, file, text, chance.choice(place)) for place in find_places(text)]
    chance.shuffle(found)
    return [make_mutant(number, *mutant) for number, mutant in enumerate(found, 1)]


def sources(tree):
    return sorted(pathlib.Path(tree, "src").rglob("*.[ch]pp"))

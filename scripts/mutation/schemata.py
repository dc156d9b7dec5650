"""A copy of the tree that holds many mutants, of which an environment variable selects one.

A function with mutants gets a body for each of them. The variables:
  CONDDP_MUTANT=N         runs mutant N, none without it
  CONDDP_MUTANTS_REACHED  a file that the process appends the numbers to whose functions it entered
"""

import collections
import re
import subprocess

HEADER = """#pragma once

#include <cstdio>
#include <cstdlib>

namespace conddp_mutation {

struct Selection {
  int chosen = 0;
  const char* log = std::getenv("CONDDP_MUTANTS_REACHED");
  bool reached[%(numbers)d] = {};

  Selection() {
    if (const char* number = std::getenv("CONDDP_MUTANT")) chosen = std::atoi(number);
  }
  ~Selection() {
    std::FILE* file = log == nullptr ? nullptr : std::fopen(log, "a");
    if (file == nullptr) return;
    for (int number = 0; number < %(numbers)d; ++number)
      if (reached[number]) std::fprintf(file, "%%d\\n", number);
    std::fclose(file);
  }
};

inline bool selected(int number) {
  static Selection selection;
  if (selection.log != nullptr) selection.reached[number] = true;
  return selection.chosen == number;
}

}  // namespace conddp_mutation
"""
HEADER_NAME = "conddp_mutation.hpp"
CONFIGURATION = ["-G", "Ninja", "-D", "CMAKE_BUILD_TYPE=Release", "-D", "CONDDP_WERROR=OFF",
                 # Assertions of Eigen and the standard library, which the sanitizers' tests have too.
                 "-D", "CMAKE_CXX_FLAGS_RELEASE=-O2 -w -D_GLIBCXX_ASSERTIONS"]
PLACE = re.compile(r"([^\s:(\x1b]+\.[ch]pp):(\d+)")


def write_where_changed(path, text):
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def with_mutants(text, mutants):
    """A source text with mutants in it, and the lines on which each stands: number, first, last; with
    the number None those of a whole function."""
    by_body = collections.defaultdict(list)
    for mutant in mutants:
        by_body[mutant.mutation.body_start, mutant.mutation.body_end].append(mutant)
    out, lines, done = "", [], 0

    def line():
        return out.count("\n") + 1

    for (start, end), group in sorted(by_body.items()):
        out += text[done:start]
        begin = line()
        out += "{\n"
        for mutant in group:
            cut = mutant.mutation
            out += f"if (::conddp_mutation::selected({mutant.number})) "
            first = line()
            out += text[start:cut.start] + cut.replacement + text[cut.end:end]
            lines.append((mutant.number, first, line()))
            out += "\nelse "
        out += text[start:end] + "\n}"
        lines.append((None, begin, line()))
        done = end
    out += text[done:]
    include = f'#include "{HEADER_NAME}"\n'
    if "#pragma once\n" in out:
        before, after = out.split("#pragma once\n", 1)
        head = before + "#pragma once\n" + include
        out = head + after
    else:
        out = include + out
    return out, [(number, first + 1, last + 1) for number, first, last in lines]


class MutatedTree:
    """The copy, below build/mutate, and its build."""

    def __init__(self, root):
        self.root = root
        self.tree = root / "build/mutate/tree"
        self.build_folder = root / "build/mutate/release"
        self.lines = {}  # of each file: (number, first line, last line)

    def write(self, mutants, numbers):
        """Links the tree but for its sources, of which it writes copies with the mutants in them."""
        self.tree.mkdir(parents=True, exist_ok=True)
        for entry in self.root.iterdir():
            link = self.tree / entry.name
            if entry.name not in ("src", "build", "out", ".git") and not link.is_symlink():
                link.symlink_to(entry)
        by_file = collections.defaultdict(list)
        for mutant in mutants:
            by_file[mutant.file].append(mutant)
        copies = {self.tree / "src" / HEADER_NAME}
        write_where_changed(self.tree / "src" / HEADER_NAME, HEADER % {"numbers": numbers + 1})
        for path in sorted((self.root / "src").rglob("*")):
            if not path.is_file():
                continue
            file = str(path.relative_to(self.root))
            text = path.read_text(encoding="utf-8")
            self.lines[file] = []
            if file in by_file:
                text, self.lines[file] = with_mutants(text, by_file[file])
            write_where_changed(self.tree / file, text)
            copies.add(self.tree / file)
        for path in (self.tree / "src").rglob("*"):
            if path.is_file() and path not in copies:
                path.unlink()

    def build(self, targets):
        """Returns the compiler's output where that fails, otherwise nothing."""
        if not (self.build_folder / "build.ninja").is_file():
            configure = subprocess.run(["cmake", "-S", self.tree, "-B", self.build_folder, *CONFIGURATION],
                                       capture_output=True, text=True)
            if configure.returncode != 0:
                raise SystemExit(configure.stdout + configure.stderr)
        run = subprocess.run(["cmake", "--build", self.build_folder, "--target", *targets, "--", "-k", "0"],
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        return run.stdout if run.returncode != 0 else ""

    def culprits(self, output):
        """The numbers of the mutants that errors of the compiler name; all of a function where its
        bodies contradict each other."""
        found, context = set(), []
        for line in output.splitlines():
            context.append(line)
            if " error: " not in line:
                if " warning: " in line or line.startswith("["):
                    context = []
                continue
            places = [(self.source(file), int(number)) for text in context
                      for file, number in PLACE.findall(text)]
            blamed = {n for place in places for n in self.at(*place) if n is not None}
            if not blamed:
                functions = [(file, first, last) for file, number in places
                             for n, first, last in self.lines.get(file, [])
                             if n is None and first <= number <= last]
                blamed = {n for file, first, last in functions for n, begin, _ in self.lines[file]
                          if n is not None and first <= begin <= last}
            found |= blamed
            context = []
        return found

    def source(self, file):
        marker = "/tree/src/"
        return "src/" + file.split(marker)[1] if marker in file else file.replace("../tree/", "")

    def at(self, file, line):
        return [number for number, first, last in self.lines.get(file, []) if first <= line <= last]

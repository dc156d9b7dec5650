"""Runs unit tests against mutants and keeps the results."""

import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import resource
import signal
import subprocess
import tempfile
import time

MEMORY = 8 << 30  # bytes of address space a run may take


def limit():
    os.nice(5)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run_tests(binary, tree, environment, timeout=None, tests="*"):
    """What ended a run of unit tests, or an empty text: a failed test, a signal, the time limit."""
    with tempfile.TemporaryFile(mode="w+", errors="replace") as output:
        process = subprocess.Popen(
            [binary, "--gtest_brief=1", f"--gtest_filter={tests}"], cwd=tree, stdout=output,
            stderr=subprocess.STDOUT, start_new_session=True, preexec_fn=limit,
            env={**os.environ, "GTEST_FAIL_FAST": "1", **environment})
        try:
            code = process.wait(timeout)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return "time limit"
        output.seek(0)
        if code == 0:
            return ""
        failed = re.search(r"^\[  FAILED  \] ([^\s,]+)", output.read(), re.MULTILINE)
        if failed:
            return failed.group(1)
        return signal.Signals(-code).name if code < 0 else f"exit status {code}"


class Suite:
    """The unit tests of a layer, and what they do without a mutant."""

    def __init__(self, root, tree, build_folder, layer):
        self.tree, self.layer = tree, layer
        self.binary = build_folder / "bin" / f"test_{layer}"
        self.fingerprint = hashlib.sha256(self.binary.read_bytes()).hexdigest()
        self.sources = sorted((root / "tests" / layer).rglob("*_test.cpp"))
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder) / "reached"
            begin = time.monotonic()
            failed = run_tests(self.binary, tree, {"CONDDP_MUTANTS_REACHED": str(log)})
            self.seconds = time.monotonic() - begin
            if failed:
                raise SystemExit(f"scripts/mutate: test_{layer} fails without a mutant: {failed}")
            self.reached = set(map(int, log.read_text().split())) if log.is_file() else set()

    def own_tests(self, file):
        """A filter for the tests of a source file's name: those that are likely to fail."""
        stem = pathlib.Path(file).stem
        names = sorted({name for source in self.sources if source.stem.startswith(stem) for name in
                        re.findall(r"^TEST(?:_[FP])?\((\w+),", source.read_text(encoding="utf-8"), re.M)})
        return ":".join(f"{name}.*:*/{name}.*" for name in names)

    def run(self, mutant):
        if mutant.number not in self.reached:
            return {"status": "survived", "by": "", "reached": False}
        by = ""
        for tests in filter(None, (self.own_tests(mutant.file), "*")):
            by = by or run_tests(self.binary, self.tree, {"CONDDP_MUTANT": str(mutant.number)},
                                 3 * self.seconds + 5, tests)
        return {"status": "killed" if by else "survived", "by": by, "reached": True}


class Results:
    """A file of lines of JSON, one for each run; the last one of a mutant counts. Results of other
    sources are dropped; what survived is tried again with other tests."""

    def __init__(self, path, sources_fingerprint, fresh):
        self.path, self.known = path, {}
        head = {"sources": sources_fingerprint}
        lines = path.read_text(encoding="utf-8").splitlines() if path.is_file() and not fresh else []
        if lines and json.loads(lines[0]) == head:
            self.known = {entry["number"]: entry for entry in map(json.loads, lines[1:])}
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(head) + "\n", encoding="utf-8")

    def add(self, mutant, **result):
        entry = {"number": mutant.number, "file": mutant.file, "line": mutant.line,
                 "kind": mutant.mutation.kind, "original": mutant.original, "mutated": mutant.mutated,
                 **result}
        self.known[mutant.number] = entry
        with self.path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry) + "\n")

    def status(self, mutant):
        return self.known.get(mutant.number, {}).get("status")

    def is_settled(self, mutant, suite):
        status = self.status(mutant)
        return status == "killed" or (
            status == "survived" and self.known[mutant.number].get("tests") == suite.fingerprint)


def run_all(mutants, suites, results, jobs, report):
    """Runs what is not settled."""
    waiting = [m for m in mutants if not results.is_settled(m, suites[m.layer])]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        running = {pool.submit(suites[m.layer].run, m): m for m in waiting}
        for count, future in enumerate(concurrent.futures.as_completed(running), 1):
            mutant = running[future]
            results.add(mutant, tests=suites[mutant.layer].fingerprint, **future.result())
            report(count, len(waiting), mutant, results.known[mutant.number])

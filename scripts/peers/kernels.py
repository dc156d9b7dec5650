"""Pinocchio's algorithms beside our rigid-body kernel."""

import json
import math
import os

from conddp_tool import BINARIES, ROOT, output_of

#: our benchmark's name of a robot: (URDF in problems/robots or in the folder of others, base)
ROBOTS = {
    "quadruped": ("problems/robots/quadruped.urdf", "floating"),
    "arm7": ("problems/robots/arm7.urdf", "fixed"),
    "hyq": ("hyq.urdf", "floating"),
    "panda": ("panda.urdf", "fixed"),
    "talos_reduced": ("talos_reduced.urdf", "floating"),
}
#: row: (Pinocchio's algorithms, our benchmarks), times added up
ROWS = {
    "inverse dynamics (RNEA)": (["rnea"], ["rnea"]),
    "inertia matrix (CRBA)": (["crba"], ["crba"]),
    "derivatives of inverse dynamics, and M": (["rnea_derivatives"], ["derivatives_and_M"]),
    "derivatives of forward dynamics": (["aba_derivatives"],
                                        ["derivatives_and_M", "factor_and_solve"]),
}


def pinocchio_times(folder, urdf, base):
    lines = output_of([folder / "pinocchio_kernels", urdf, base]).splitlines()
    return {name: float(time) for name, time in (line.split() for line in lines)}


def our_times(folder):
    """Microseconds a knot by robot, benchmark and scalar: medians."""
    os.environ["CONDDP_ROBOTS_DIR"] = folder
    report = json.loads(output_of([
        BINARIES / "bench_kernel", "--benchmark_min_time=0.005", "--benchmark_repetitions=21",
        "--benchmark_report_aggregates_only=true", "--benchmark_format=json"]))
    times = {}
    for entry in report["benchmarks"]:
        if entry["aggregate_name"] == "median":
            times[tuple(entry["run_name"].split("/"))] = entry["knot"] * 1e6
    return times


def compare(folder, peers):
    """`folder` has the robots, `peers` the program with Pinocchio's algorithms."""
    ours = our_times(os.path.abspath(folder))
    table = {}
    for robot, (path, base) in ROBOTS.items():
        urdf = ROOT / path if "/" in path else os.path.join(os.path.abspath(folder), path)
        if not os.path.exists(urdf) or (robot, "rnea", "double") not in ours:
            continue
        theirs = pinocchio_times(peers, urdf, base)
        table[robot] = [
            (row, sum(theirs[name] for name in algorithms),
             *(math.fsum(ours[robot, name, scalar] for name in benchmarks)
               for scalar in ("double", "lanes")))
            for row, (algorithms, benchmarks) in ROWS.items()]
    return table

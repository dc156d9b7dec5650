"""Counts who solves what from far-away starts: see scripts/peers/starts."""

import argparse
import json
import multiprocessing
import os
import shlex
import subprocess
import sys
from importlib.metadata import version

os.environ["OMP_NUM_THREADS"] = "1"  # before a peer is loaded

import crocoddyl  # noqa: E402

import start_runs  # noqa: E402
import start_set  # noqa: E402
import start_table  # noqa: E402
from conddp_tool import BINARIES, ROOT, Untranslatable, robot_settings  # noqa: E402
from machine import processor  # noqa: E402


def arguments():
    parser = argparse.ArgumentParser(prog="scripts/peers/starts", description=(
        "Solves problems with conddp, Crocoddyl and Aligator from the same far-away starts and "
        "prints how many each solves. The exit status is 1 where Crocoddyl solves more starts of a "
        "row than conddp."))
    robots = os.environ.get("CONDDP_ROBOTS_DIR", "")
    parser.add_argument("--robots", default=robots,
                        help="folder with hyq.urdf and others (by default CONDDP_ROBOTS_DIR)")
    parser.add_argument("--quick", action="store_true", help="a fixed part of the starts")
    parser.add_argument("--row", action="append", default=[], metavar="NAME",
                        help="only rows whose name contains this")
    parser.add_argument("--limit", type=int, help="only so many starts of each row")
    parser.add_argument("--jobs", type=int, default=1, help="processes that solve")
    parser.add_argument("--again", action="store_true", help="run conddp anew")
    parser.add_argument("--no-aligator", action="store_true",
                        help="of Aligator only what is known already")
    parser.add_argument("--json", action="store_true", help="JSON instead of tables")
    parser.add_argument("--list-failures", action="store_true",
                        help="how to repeat every start that Crocoddyl alone solves")
    return parser.parse_args()


def chosen(wanted):
    """The instances that are asked for, with the settings that say where their robots are."""
    picked, seen = [], {}
    for instance in start_set.instances():
        if wanted.row and not any(name.lower() in instance.row.lower() for name in wanted.row):
            continue
        if wanted.quick and not instance.quick:
            continue
        seen[instance.row] = seen.get(instance.row, 0) + 1
        if wanted.limit is None or seen[instance.row] <= wanted.limit:
            picked.append((instance, robot_settings(instance.file, wanted.robots)))
    return picked


def solve(picked, tools, jobs, again):
    """Computes what these tools miss and returns all records by (tool, key)."""
    records, tasks = start_runs.load(), []
    for instance, where in picked:
        known = {}
        for tool in tools:
            record = records.get((tool, start_runs.key_of(tool, instance, where)))
            if record is not None and not (again and tool == "conddp"):
                known[tool] = record
        if len(known) < len(tools):
            tasks.append((instance, where, tools, known))
    start_runs.RESULTS.parent.mkdir(parents=True, exist_ok=True)
    with (multiprocessing.get_context("spawn").Pool(max(1, jobs)) as pool,
          open(start_runs.RESULTS, "a", encoding="utf-8") as file):
        for done, made in enumerate(pool.imap_unordered(start_runs.run, tasks), 1):
            for record in made:
                records[record["tool"], record["key"]] = record
                file.write(json.dumps(record) + "\n")
                file.flush()
                print(f"{done}/{len(tasks)} {record['name']}: {record['tool']}: {record['status']}",
                      file=sys.stderr)
    return records


def revision():
    def git(*words):
        result = subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True)
        return result.stdout.strip()
    changed = git("status", "--porcelain", "--", "src", "tests/bench")
    return git("rev-parse", "--short", "HEAD") + (" with local changes" if changed else "")


def header():
    return {"machine": processor(), "revision": revision(),
            "binary": start_runs.contents(BINARIES / "bench_solve_times"),
            "crocoddyl": crocoddyl.__version__, "aligator": version("libaligator"),
            "command": os.environ.get("STARTS_COMMAND", "scripts/peers/starts").strip(),
            "stop": start_runs.STOP, "mu_init": start_runs.MU_INIT,
            "tolerance": start_runs.TOLERANCE, "iterations": start_runs.MOST_ITERATIONS}


def as_markdown(starts):
    about, row = header(), start_table.counts(starts)
    share = "–" if row["share"] is None else f"{100 * row['share']:.1f} %"
    return "\n".join([
        f"`{about['command']}` on {about['machine']}, conddp {about['revision']} `box_fddp`, "
        f"Crocoddyl {about['crocoddyl']} SolverBoxFDDP (th_stop {about['stop']:g}), Aligator "
        f"{about['aligator']} SolverProxDDP (mu_init {about['mu_init']:g}, tolerance "
        f"{about['tolerance']:g}); at most {about['iterations']} iterations each.\n",
        start_table.table(starts),
        f"conddp solves {row['conddp']} of the {row['anybody']} starts that anybody solves: "
        f"{share}.\n",
        "Local minima, which cost more than the best known answer from the same initial state: "
        + ", ".join(f"{name} {len(start_table.dearer(starts, tool))}"
                    for tool, name in start_table.NAMES.items()) + ".\n",
        start_table.beside_aligator(starts),
        start_table.table(starts, start_table.kind, "start"),
        start_table.disagreements(starts)])


def as_json(starts):
    rows = {name: start_table.counts(group) for name, group in
            start_table.grouped(starts, lambda start: start.instance.row).items()}
    single = [{"name": start.instance.name, "row": start.instance.row,
               "quick": start.instance.quick, "conddp_solved": start.conddp,
               "crocoddyl_solved": start.crocoddyl, "aligator_solved": start.aligator,
               **start.records} for start in starts]
    return json.dumps({**header(), "rows": rows, "total": start_table.counts(starts),
                       "starts": single}, indent=1)


def failures(starts, where):
    """How to repeat what Crocoddyl solves and conddp does not."""
    lines = []
    for start in starts:
        if start.crocoddyl and not start.conddp:
            settings = where[start.instance]
            ours = start.ours
            lines += [f"# {start.instance.name}: conddp {ours['status']} after "
                      f"{ours.get('iterations', '?')} iterations: {start_table.found(ours)}; "
                      f"{ours['message']}",
                      f"#   Crocoddyl: {start.theirs['iterations']} iterations, cost "
                      f"{start.theirs['check']['cost']:.9g}",
                      shlex.join(["build/release/bin/bench_solve_times",
                                  *start_runs.bench_words(start.instance, settings)]),
                      shlex.join(["build/release/bin/conddp",
                                  *start_runs.tool_words(start.instance, settings)])]
    return "\n".join(lines)


def main():
    wanted = arguments()
    try:
        picked = chosen(wanted)
    except Untranslatable as refusal:
        sys.exit(f"scripts/peers/starts: {refusal}")
    tools = [tool for tool in start_runs.TOOLS if not (wanted.no_aligator and tool == "aligator")]
    records = solve(picked, tools, wanted.jobs, wanted.again)
    starts = [start_table.Start(instance, {tool: records.get(
        (tool, start_runs.key_of(tool, instance, where))) for tool in start_runs.TOOLS})
              for instance, where in picked]
    if wanted.list_failures:
        print(failures(starts, dict(picked)))
    else:
        print(as_json(starts) if wanted.json else as_markdown(starts))
    rows = start_table.grouped(starts, lambda start: start.instance.row).values()
    return int(any(row["conddp"] < row["crocoddyl"] for row in map(start_table.counts, rows)))


if __name__ == "__main__":
    sys.exit(main())

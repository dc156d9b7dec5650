"""Counts over rows of starts, as Markdown and as JSON."""

import statistics

from start_check import GAP, is_solved

EQUAL = 1e-6  # costs, relative
NAMES = {"conddp": "conddp", "crocoddyl": "Crocoddyl", "aligator": "Aligator"}


class Start:
    """What the tools made of an instance; Aligator's record is None where it was not run."""

    def __init__(self, instance, records):
        self.instance, self.records = instance, records
        self.ours, self.theirs = records["conddp"], records["crocoddyl"]
        self.conddp, self.crocoddyl, self.aligator = (self.is_solved_by(tool) for tool in NAMES)

    def is_solved_by(self, tool):
        record = self.records[tool]
        return record is not None and is_solved(record.get("check"))

    @property
    def initial_state(self):
        """What starts from the same state have in common."""
        instance = self.instance
        return instance.row, instance.state, instance.seed if instance.state else 0

    @property
    def is_solved_by_anybody(self):
        return self.conddp or self.crocoddyl or self.aligator

    @property
    def is_false_verdict(self):
        """conddp says that there is no solution, and somebody has one."""
        return self.ours["status"] == "infeasible" and self.is_solved_by_anybody

    def verdict(self, peer):
        """Of conddp's answer and a peer's, whose cost is lower."""
        if not (self.conddp and self.is_solved_by(peer)):
            return None
        ours, theirs = (self.records[tool]["check"]["cost"] for tool in ("conddp", peer))
        if abs(ours - theirs) <= EQUAL * max(abs(ours), abs(theirs)):
            return "equal"
        return "conddp_better" if ours < theirs else f"{peer}_better"

    @property
    def has_other_problem(self):
        """The costs of the guess or of conddp's answer differ: the translation is not the same
        problem."""
        pairs = [self.ours.get("guess_costs", (0, 0))]
        check = self.ours.get("check")
        if check is not None and check["gap"] <= GAP:
            pairs.append((self.ours["claimed_cost"], check["cost"]))
        return any(abs(ours - theirs) > EQUAL * max(abs(ours), abs(theirs))
                   for ours, theirs in pairs)


def counts(starts):
    """The figures of a row."""
    anybody = sum(start.is_solved_by_anybody for start in starts)
    row = {"instances": len(starts),
           **{tool: sum(start.is_solved_by(tool) for start in starts) for tool in NAMES},
           "aligator_instances": sum(start.records["aligator"] is not None for start in starts),
           "only_conddp": sum(start.conddp and not start.crocoddyl for start in starts),
           "only_crocoddyl": sum(start.crocoddyl and not start.conddp for start in starts),
           "anybody": anybody, "share": None, **compared(starts, "crocoddyl"),
           "beside_aligator": compared(starts, "aligator"),
           "false_verdicts": sum(start.is_false_verdict for start in starts)}
    if anybody:
        row["share"] = row["conddp"] / anybody
    return row


def compared(starts, peer):
    """Figures of the starts that conddp and a peer solve."""
    both = [start for start in starts if start.conddp and start.is_solved_by(peer)]
    verdicts = [start.verdict(peer) for start in both]
    figures = {name: verdicts.count(name) for name in ("equal", "conddp_better", f"{peer}_better")}
    for tool in ("conddp", peer):
        for figure in ("iterations", "seconds"):
            figures[f"{tool}_{figure}"] = statistics.median(
                start.records[tool][figure] for start in both) if both else None
    return figures


def grouped(starts, key):
    groups = {}
    for start in starts:
        groups.setdefault(key(start), []).append(start)
    return groups


def iterations(row, peer):
    return " / ".join("–" if row[f"{tool}_iterations"] is None else
                      f"{row[f'{tool}_iterations']:g}" for tool in ("conddp", peer))


def line(name, row):
    fewer = "**" if row["conddp"] < row["crocoddyl"] else ""
    measured = row["aligator_instances"]
    aligator = (f"{row['aligator']}" if measured == row["instances"] else
                f"{row['aligator']} of {measured}" if measured else "–")
    return (f"| {name} | {row['instances']} | {fewer}{row['conddp']}{fewer} | {row['crocoddyl']} "
            f"| {aligator} | {row['only_conddp']} | {row['only_crocoddyl']} "
            f"| {iterations(row, 'crocoddyl')} | {iterations(row['beside_aligator'], 'aligator')} "
            f"| {row['equal']} / {row['conddp_better']} / {row['crocoddyl_better']} "
            f"| {row['false_verdicts']} |")


def table(starts, key=lambda start: start.instance.row, title="problem"):
    """One line for each value of `key`, and the total."""
    lines = [f"| {title} | starts | conddp | Crocoddyl | Aligator | conddp, not Crocoddyl "
             "| Crocoddyl, not conddp | iterations, median where both solve: conddp / Crocoddyl "
             "| the same: conddp / Aligator "
             "| costs equal / conddp's lower / Crocoddyl's lower | false verdicts |",
             "|---|---|---|---|---|---|---|---|---|---|---|"]
    lines += [line(name, counts(group)) for name, group in grouped(starts, key).items()]
    lines.append(line("all", counts(starts)))
    return "\n".join(lines) + "\n"


def kind(start):
    instance = start.instance
    noise = f", guess noise {instance.guess:g}" if instance.guess else ""
    return f"x0 ±{instance.state:g}{noise}, {instance.controls} controls"


def dearer(starts, tool):
    """Of its solved starts those whose answer costs more than the best known answer from the same
    initial state, whatever guess and tool that has: local minima."""
    best = {}
    for start in starts:
        for name in NAMES:
            if start.is_solved_by(name):
                known = best.get(start.initial_state, float("inf"))
                best[start.initial_state] = min(known, start.records[name]["check"]["cost"])
    return [start for start in starts if start.is_solved_by(tool) and
            start.records[tool]["check"]["cost"] > best[start.initial_state] * (1 + EQUAL) + EQUAL]


def beside_aligator(starts):
    """What the table leaves out of Aligator, in a sentence."""
    both = counts(starts)["beside_aligator"]
    only = sum(start.aligator and not start.conddp for start in starts)
    ours = sum(start.conddp and not start.aligator and start.records["aligator"] is not None
               for start in starts)
    return (f"Of the starts that Aligator was given conddp solves {ours} that Aligator does not, "
            f"Aligator {only} that conddp does not. Where both do, costs are equal in "
            f"{both['equal']}, conddp's is lower in {both['conddp_better']}, Aligator's in "
            f"{both['aligator_better']}.\n")


def disagreements(starts):
    """Lines of what the check and the tools see differently."""
    lines = []
    for start in starts:
        for tool, name in NAMES.items():
            record = start.records[tool] or {}
            if record.get("claimed") and not start.is_solved_by(tool):
                lines.append(f"- {start.instance.name}: {name} claims convergence, not confirmed: "
                             f"{found(record)}")
        if start.is_false_verdict:
            lines.append(f"- {start.instance.name}: conddp says infeasible, a false verdict")
        if start.has_other_problem:
            lines.append(f"- {start.instance.name}: not the same problem for both: costs of the "
                         f"guess {start.ours['guess_costs']}, conddp's cost {start.ours['claimed_cost']}, "
                         f"{found(start.ours)}")
    return "\n".join(lines)


def found(record):
    check = record.get("check")
    if check is None:
        return "nothing finite"
    return (f"cost {check['cost']:.6g}, may fall by {check['decrease']:.1e}, "
            f"gap {check['gap']:.1e}, bounds {check['bound']:.1e}, "
            f"gradient {check['gradient']:.1e}")

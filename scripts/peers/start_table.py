"""Counts over rows of starts, as Markdown and as JSON."""

import statistics

from start_check import GAP, is_solved

EQUAL = 1e-6  # costs, relative


class Start:
    """What both tools made of an instance."""

    def __init__(self, instance, ours, theirs):
        self.instance, self.ours, self.theirs = instance, ours, theirs
        self.conddp, self.crocoddyl = (is_solved(record.get("check")) for record in (ours, theirs))

    @property
    def initial_state(self):
        """What starts from the same state have in common."""
        instance = self.instance
        return instance.row, instance.state, instance.seed if instance.state else 0

    @property
    def is_false_verdict(self):
        """conddp says that there is no solution, and somebody has one."""
        return self.ours["status"] == "infeasible" and (self.conddp or self.crocoddyl)

    @property
    def verdict(self):
        """Of two answers, whose cost is lower."""
        if not (self.conddp and self.crocoddyl):
            return None
        ours, theirs = self.ours["check"]["cost"], self.theirs["check"]["cost"]
        if abs(ours - theirs) <= EQUAL * max(abs(ours), abs(theirs)):
            return "equal"
        return "conddp_better" if ours < theirs else "crocoddyl_better"

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
    both = [start for start in starts if start.conddp and start.crocoddyl]
    verdicts = [start.verdict for start in starts]
    anybody = sum(start.conddp or start.crocoddyl for start in starts)
    row = {"instances": len(starts),
           "conddp": sum(start.conddp for start in starts),
           "crocoddyl": sum(start.crocoddyl for start in starts),
           "only_conddp": sum(start.conddp and not start.crocoddyl for start in starts),
           "only_crocoddyl": sum(start.crocoddyl and not start.conddp for start in starts),
           "anybody": anybody,
           **{name: verdicts.count(name)
              for name in ("equal", "conddp_better", "crocoddyl_better")},
           "false_verdicts": sum(start.is_false_verdict for start in starts)}
    row["share"] = row["conddp"] / anybody if anybody else None
    for tool, side in (("conddp", "ours"), ("crocoddyl", "theirs")):
        for figure in ("iterations", "seconds"):
            row[f"{tool}_{figure}"] = statistics.median(
                getattr(start, side)[figure] for start in both) if both else None
    return row


def grouped(starts, key):
    groups = {}
    for start in starts:
        groups.setdefault(key(start), []).append(start)
    return groups


def line(name, row):
    iterations = " / ".join("–" if row[f"{tool}_iterations"] is None else
                            f"{row[f'{tool}_iterations']:g}" for tool in ("conddp", "crocoddyl"))
    fewer = "**" if row["conddp"] < row["crocoddyl"] else ""
    return (f"| {name} | {row['instances']} | {fewer}{row['conddp']}{fewer} | {row['crocoddyl']} "
            f"| {row['only_conddp']} | {row['only_crocoddyl']} | {iterations} "
            f"| {row['equal']} / {row['conddp_better']} / {row['crocoddyl_better']} "
            f"| {row['false_verdicts']} |")


def table(starts, key=lambda start: start.instance.row, title="problem"):
    """One line for each value of `key`, and the total."""
    lines = [f"| {title} | starts | conddp | Crocoddyl | only conddp | only Crocoddyl "
             "| iterations, median where both solve "
             "| costs equal / conddp's lower / Crocoddyl's lower | false verdicts |",
             "|---|---|---|---|---|---|---|---|---|"]
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
    best, found = {}, []
    for start in starts:
        for solved, record in ((start.conddp, start.ours), (start.crocoddyl, start.theirs)):
            if solved:
                known = best.get(start.initial_state, float("inf"))
                best[start.initial_state] = min(known, record["check"]["cost"])
    for start in starts:
        solved, record = ((start.conddp, start.ours) if tool == "conddp" else
                          (start.crocoddyl, start.theirs))
        if solved and record["check"]["cost"] > best[start.initial_state] * (1 + EQUAL) + EQUAL:
            found.append(start)
    return found


def disagreements(starts):
    """Lines of what the check and the tools see differently."""
    lines = []
    for start in starts:
        for tool, record, solved in (("conddp", start.ours, start.conddp),
                                     ("Crocoddyl", start.theirs, start.crocoddyl)):
            if record.get("claimed") and not solved:
                lines.append(f"- {start.instance.name}: {tool} claims convergence, not confirmed: "
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

"""What scripts/metamorphic changes of an expanded problem document. Factors are powers of two, or of ten for costs."""

import re

STATES, CONTROLS = ("state", "configuration", "velocity", "cycle"), ("control", "control_rate")
STATE_BLOCKS = ("states", "positions", "velocities")
VALUES = {"reference", "lower", "upper", "equals", "at_least", "at_most", "centers", "offset"}
OVER_TIME = ("times", "knots", "count", "time", "knot", "interpolation")
POWERS = {"quadratic": 2, "quadratic_barrier": 2, "smooth_l2": 2, "smooth_l1": 1, "linear": 1}
PENALTIES = {"augmented_lagrangian.initial_penalty", "augmented_lagrangian.max_penalty"}
COST_OPTIONS = {"tolerances.stationarity", "tolerances.complementarity", "regularization.initial"} | PENALTIES


class NotCovered(Exception):
    """Why a change cannot be made."""


def multiply_options(document, paths, factor):
    for group, key in (path.split(".") for path in paths):
        document["solver"][group][key] *= factor


def terms(document, *blocks):
    """What stands in these blocks: the name that its cost has in a solution, and where it stands."""
    return [(prefix + name, part[block], name) for part, prefix in ((document, ""), (document["terminal"], "terminal/"))
            for block in blocks for name in list(part.get(block) or {})]


def multiply_weights(document, factor, names=None):
    """Those of all terms, or of some."""
    for full_name, block, name in terms(document, "costs", "constraints"):
        if "weight" in block[name] and (names is None or full_name in names):
            block[name]["weight"] *= factor
            for phase in document["phases"] if full_name == name else ():
                if name in phase.get("weights", {}):
                    phase["weights"][name] *= factor
    return document


def scaled(value, factor, names=None):
    """Numbers of components times the factor; a mapping of components may have no other names than these."""
    if isinstance(value, list):
        return [scaled(entry, factor, names) for entry in value]
    if not isinstance(value, dict):
        return value if value is None or isinstance(value, str) else value * factor
    known = {"values", "state", "from", "to", "keyframes", "constant", *(names if names is not None else value)} - {"file"}
    if other := [key for key in value if key not in known and key not in OVER_TIME and "*" not in key]:
        raise NotCovered(f"values with '{other[0]}'")
    return {key: entry if key in OVER_TIME and key not in (names or ()) else scaled(entry, factor, names)
            for key, entry in value.items()}


def mapped(rows, of_text, of_number=lambda name, number: number):
    """Expressions, or factors of columns by name, each replaced."""
    if isinstance(rows, list):
        return [mapped(row, of_text, of_number) for row in rows]
    if isinstance(rows, dict):
        return {name: of_number(name, row) if isinstance(row, (int, float)) else mapped(row, of_text, of_number)
                for name, row in rows.items()}
    return of_text(rows)


def systems(document):
    return list(document.get("systems", {"": document.get("system", {})}).values())


def columns(document, blocks):
    """Names of states or controls."""
    if any(system.get("type") != "expressions" for system in systems(document)):
        raise NotCovered("no system of equations")
    found = {name: unit for system in systems(document) for block in blocks
             for name, unit in (system.get(block) or {}).items()}
    if set(found.values()) & {"unit_quaternion", "pose"}:
        raise NotCovered("states that are no numbers")
    return found.keys()


class Units:
    """Another unit of all states, or of all controls."""

    def __init__(self, problem, document, of_states, factor):
        self.document, self.of_states, self.factor = document, of_states, factor
        self.names = columns(document, STATE_BLOCKS if of_states else ("controls",))
        self.own = problem.set_options(document)
        guess, perturbation = document["initial_guess"], document["perturbation"]
        if document["terminal"].get("lqr") or perturbation["initial_state"] or perturbation["guess"] or \
           "random" in guess or any(self.names & (system["let"].keys() | system["parameters"].keys()) for system in systems(document)):
            raise NotCovered("a regulator, random numbers, or one name of two things")
        if barred := self.own - {"tolerances.gap", "tolerances.stationarity", "tolerances.complementarity"}:
            raise NotCovered(f"options that may be in several units: {', '.join(sorted(barred))}")

    def scaled(self, value, power=1):
        return scaled(value, self.factor**power, self.names)

    def expression(self, text):
        """With each name by the factor, and the previous control."""
        def in_old_unit(match):
            is_own = not self.of_states if "[" in match.group() else match.group() in self.names
            return f"({match.group()}*{1 / self.factor!r})" if is_own else match.group()

        previous = r"\bprevious\s*\[\s*\w+\s*\]"
        if re.search(r"[\w)]\s*\[", re.sub(previous, "", text)):
            raise NotCovered("parts of vectors")
        return re.sub(previous + r"|(?<![\w.])[A-Za-z_]\w*(?!\w*\s*\()", in_old_unit, text)

    def equation(self, text):
        return f"{self.factor!r}*({self.expression(text)})" if self.of_states else self.expression(text)

    def change_term(self, term):
        kind = term.get("residual", term.get("bounds"))
        if term.get("of") or kind not in (*STATES, *CONTROLS, "expression", "combination"):
            raise NotCovered(f"the residual {kind}")
        if "rows" in term:
            term["rows"] = mapped(term["rows"], self.expression,
                                  lambda name, number: number / self.factor if name in self.names else number)
        if kind not in (STATES if self.of_states else CONTROLS):
            return
        if any(name not in self.names and "*" not in name for name in term.get("columns", [])):
            raise NotCovered("further columns of the state")
        term |= {key: self.scaled(term[key]) for key in term.keys() & VALUES}
        if "soft" in term:
            term["weight"] *= self.factor ** (-1 if term["soft"] == "l1" else -2)
        elif activation := term.get("activation"):
            activation = activation if isinstance(activation, dict) else {"kind": activation}
            weights = "matrix" if "matrix" in term else "weights"
            term[weights] = self.scaled(term[weights], -POWERS[activation["kind"]])
            in_unit = {"lower", "upper"} | ({"epsilon"} if activation["kind"] == "smooth_l1" else set())
            term["activation"] = activation | {key: self.scaled(activation[key]) for key in activation.keys() & in_unit}

    def changed(self):
        document, initial, guess = self.document, self.document["initial_state"], self.document["initial_guess"]
        for system in systems(document):
            system["let"] = mapped(system["let"], self.expression)
        for part in systems(document) + document["phases"]:
            part |= {key: mapped(part[key], self.equation) for key in part.keys() & {"rate", "next", "acceleration", "jump"}}
            if "choose" in part and self.of_states:
                part |= {key: self.scaled(part[key]) for key in part.keys() & {"lower", "upper"}}
        if initial.keys() - {"values", "state", "previous_control"}:
            raise NotCovered("a state in other words")
        of_initial, of_guess = ({"values", "state"}, "states") if self.of_states else ({"previous_control"}, "controls")
        initial |= {key: self.scaled(initial[key]) for key in initial.keys() & of_initial}
        guess[of_guess] = self.scaled(guess[of_guess])
        multiply_options(document, self.own & {"tolerances.gap" if self.of_states else "tolerances.stationarity"},
                         self.factor if self.of_states else 1 / self.factor)
        if "mesh" in document and self.of_states:
            document["mesh"]["error"] *= self.factor
        for _, block, name in terms(document, "costs", "constraints", "integrals"):
            self.change_term(block[name])
        return document


def as_expressions(document, term):
    """A constraint on states as one on expressions; None where it is more than numbers of states by name."""
    try:
        names = columns({"system": document.get("system", {})}, STATE_BLOCKS)
    except NotCovered:
        return None
    limits, origin = [term[key] for key in ("lower", "upper") if key in term], term.get("reference", 0)
    rows = term.get("columns") or [name for name in names if "bounds" not in term or
                                   any(name in limit for limit in limits if isinstance(limit, dict)) or
                                   any(not isinstance(limit, dict) for limit in limits)]
    if isinstance(origin, dict):
        origin = origin.get("values", origin)
    elif not isinstance(origin, str):
        origin = dict(zip(rows, origin if isinstance(origin, list) else [origin] * len(rows)))
    named = [value for key, value in term.items() if key in VALUES - {"reference"} and isinstance(value, dict)]
    if term.get("residual", term.get("bounds")) != "state" or "centers" in term or \
       not set(rows).union(origin, *named) <= names:
        return None
    kept = {key: value for key, value in term.items() if key not in ("bounds", "columns", "reference")}
    return kept | {"residual": "expression", "rows": {name: f"{name} - ({origin.get(name, 0)!r})" for name in rows}}


def multiply_rows(problem, document, factor, of_last):
    """Of hard constraints on the last node, or of the others; None where there are none."""
    changed, others = [], False
    for full_name, block, name in terms(document, "constraints"):
        term = block[name]
        if "soft" in term or term.get("bounds") == "control":
            continue
        rows = None if of_last != (full_name != name) else term if "rows" in term else as_expressions(document, term)
        others |= rows is None
        if rows is not None:
            changed.append(full_name)
            block[name] = rows | {key: scaled(rows[key], factor) for key in rows.keys() & VALUES} | {
                "rows": mapped(rows["rows"], lambda text: f"{factor!r}*({text})", lambda _, number: number * factor)}
            if term.get("bounds") == "state" and full_name == name and "phases" not in term:
                document["terminal"]["constraints"][f"{name}_at_the_end"] = \
                    {key: value for key, value in block[name].items() if key != "nodes"}
    own = problem.set_options(document) & (PENALTIES | {"tolerances.constraint"})
    if own and others:
        raise NotCovered("a tolerance or penalty for rows in several units")
    multiply_options(document, own & PENALTIES, factor**-2)
    multiply_options(document, own - PENALTIES, factor)
    return document if changed else None

"""What the advice of conddp means: its words, and the changes of a problem that follow it; read by scripts/advice."""

import json
import math
import re

# Changes of documents.


def at(document, path):
    """What holds the last key of a path, and that key."""
    *way, last = [int(key) if key.isdigit() else key for key in path.split(".")]
    for key in way:
        document = document[key] if isinstance(key, int) else document.setdefault(key, {})
    return document, last


def put(document, path, value):
    place, key = at(document, path)
    if value is None:
        del place[key]
    elif isinstance(value, dict) and set(value) == {"times"}:
        place[key] = scaled(place[key], value["times"])
    else:
        place[key] = value
    return document


def scaled(value, factor):
    if isinstance(value, list):
        return [scaled(v, factor) for v in value]
    if isinstance(value, dict):
        return {k: scaled(v, factor) for k, v in value.items()}
    if value is None or isinstance(value, str):
        return value
    product = value * factor
    return int(product) if isinstance(value, int) and product == int(product) else product


def widened(bound, factor, lower):
    """A bound further out."""
    if isinstance(bound, list):
        return [widened(b, factor, lower) for b in bound]
    if isinstance(bound, dict):
        return {k: widened(b, factor, lower) for k, b in bound.items()}
    return bound if bound is None or isinstance(bound, str) else bound / factor if (bound > 0) == lower else bound * factor


def terms(document, block):
    """(name, term) of costs or constraints; those of the terminal node as conddp names them."""
    own = document.setdefault(block, {})
    end = document.get("terminal", {}).get(block) or {}
    return list(own.items()) + [("terminal/" + name, term) for name, term in end.items()]


def timed(document):
    return [phase for phase in document["phases"] if "knots" in phase]


def node_of(phases, node, factor):
    """Where a node is once the phases that take time have more knots."""
    begin, moved = 0, 0
    for phase in phases:
        knots = phase.get("knots", 1)
        times = factor if "knots" in phase else 1
        if node < begin + knots:
            break
        begin, moved = begin + knots, moved + times * knots
    return moved + times * (node - begin) if node < begin + knots else moved


def with_nodes(value, phases, factor):
    """What counts knots, for the finer grid."""
    if isinstance(value, list):
        return [with_nodes(v, phases, factor) for v in value]
    if not isinstance(value, dict):
        return value
    return {k: [node_of(phases, n, factor) for n in v] if k == "knots" and isinstance(v, list)
            else node_of(phases, v, factor) if k == "knot" else with_nodes(v, phases, factor) for k, v in value.items()}


def more_knots(document, factor):
    document = with_nodes(document, document["phases"], factor)
    for phase in timed(document):
        phase["knots"] *= factor
        phase["dt"] /= factor
    return document


def more_time(document, factor):
    for phase in timed(document):
        phase["dt"] *= factor
        if isinstance(phase.get("free_duration"), dict):
            phase["free_duration"]["upper"] *= factor
    return document


def wider_bounds(document, factor, controls_only=False):
    for _, term in terms(document, "constraints"):
        if controls_only and term.get("bounds") != "control":
            continue
        if term.get("from") == "urdf":
            term["scale"] = factor * term.get("scale", 1)
        for key in ("lower", "upper", "at_least", "at_most"):
            if key in term:
                term[key] = widened(term[key], factor, key in ("lower", "at_least"))
    return document


def without_violated(document, run, every):
    violated = sorted(run.answer.get("constraints") or [], key=lambda c: -c["violation"])
    for constraint in violated if every else violated[:1]:
        end = constraint["name"].startswith("terminal/")
        of = document["terminal"] if end else document
        of["constraints"].pop(constraint["name"].removeprefix("terminal/"), None)
    return document


def other_guess(document, which):
    guess = document.setdefault("initial_guess", {})
    if which == 0:
        guess["states"] = "interpolate" if guess.get("states") == "initial" else "initial"
    elif which == 1:
        robot = "robot" in document
        guess["controls"] = {"constant": 0.1} if not robot else "zero" if guess.get("controls") == "quasi_static" else "quasi_static"
    else:
        document["perturbation"] = {"guess": 0.3, "seed": 2}
    return document


def effort(document):
    """The weight of the cost on all controls."""
    weights = [t["weight"] for _, t in terms(document, "costs") if t["residual"].startswith("control") and "weight" in t]
    return max(weights, default=0) or 1e-3


def add(document, block, term):
    document[block] = (document.get(block) or {}) | {"advised": term}
    return document


def weights_of(document, factor, chosen=lambda name, term: True):
    for name, term in terms(document, "costs"):
        if "weight" in term and chosen(name, term):
            term["weight"] *= factor
    return document


def largest_cost(run):
    costs = run.answer.get("cost_by_name") or {"": 0}
    return max(costs, key=lambda name: abs(costs[name] or 0))


# By how many times what is missing a distance is made wider.
WIDER = 1.2


def wider_distance(document, finding):
    term = dict(terms(document, "constraints"))[finding["subject"]]
    more = WIDER * finding["value"]
    for key, sign in (("at_least", 1), ("margin", 1), ("lower", 1), ("upper", -1), ("at_most", -1)):
        if isinstance(term.get(key), (int, float)):
            term[key] += sign * more
        elif isinstance(term.get(key), list):
            term[key] = [None if v is None else v + sign * more for v in term[key]]
    return document


def longer_table(document, finding):
    """Straight on at both ends, as it is read there."""
    read = float(re.search(r"read at ([-+.e\d]+)", finding["message"])[1])
    table = document["tables"][finding["subject"]]
    x, y = table["points"], table["values"]
    far = 10 * (abs(read) + x[-1] - x[0])
    table["values"] = [y[0] - (y[1] - y[0]) / (x[1] - x[0]) * far, *y, y[-1] + (y[-1] - y[-2]) / (x[-1] - x[-2]) * far]
    table["points"] = [x[0] - far, *x, x[-1] + far]
    return document


def more_thrusters(document):
    thrusters = document["robot"]["actuation"]["thrusters"]
    first = thrusters[0]
    for name, direction in (("advised_x", [1, 0, 0]), ("advised_y", [0, 1, 0]), ("advised_z", [0, 0, 1])):
        thrusters.append(first | {"name": name, "direction": direction, "torque_ratio": 0.1})
    return document


def smooth(document):
    text = json.dumps(document)
    changed = re.sub(r"\b(norm|abs)\(([^()]*)\)", r"smooth_\1(\2, 1e-2)", text)
    changed = re.sub(r"\bsqrt\(([^()]*)\)", r"sqrt(\1 + 1e-4)", changed)
    return json.loads(changed) if changed != text else None


def smoother_costs(document):
    found = False
    for _, term in terms(document, "costs"):
        activation = term.get("activation")
        if isinstance(activation, dict) and "epsilon" in activation:
            activation["epsilon"] *= 10
            found = True
    return document if found else None


def stepped(document, longest):
    step = max(phase["dt"] for phase in timed(document))
    return more_knots(document, math.ceil(1.001 * step / longest))


def everywhere(document, name):
    for key in ("knots", "phases"):
        document["costs" if name in document["costs"] else "constraints"][name].pop(key, None)
    return document


def cone(contact):
    return {"residual": "friction_cone", "contacts": [contact]}


# Advice: its kind, its words, and functions of the document, the failed run, the finding and the words that matched, one for
# each value to try. None: it takes a thought.


def stiffer(document, contact):
    return put(document, f"contacts.{contact}.baumgarte.kd", {"times": 4}) if contact else document


def each(change, *values):
    return [lambda d, r, f, m, v=v: change(d, v) for v in values]


def setting(path, *values):
    return each(lambda d, v: put(d, path, v), *values)


def larger_tolerances(d, r, f, m):
    for name in re.findall(r"solver\.tolerances\.(\w+)", m[0]):
        put(d, "solver.tolerances." + name, 2 * (r.answer["residuals"].get(name) or 1e-6))
    return d


def nearby_state(d, r, f, m):
    return put(d, "initial_state.values." + m[1], float(m[2])) if "the initial state" in m[0] else None


ANOTHER_GUESS = each(other_guess, 0, 1, 2)
CONTROL = {"residual": "control"}
RADAU5 = setting("integrator", "radau5")
RK4 = setting("integrator", "rk4")
MORE_KNOTS = each(more_knots, 2, 4, 16)
ADVICE = [(kind, re.compile(words), tries) for kind, words, tries in (
    ("mesh", r"'mesh', or still shorter steps:[^;]*not enough", setting("mesh", {"error": 1e-3})),
    ("another value of the state", r"'([\w/]+): (\S+)' in the (?:initial state|guess), or equations that hold at [^,;]+, too", [nearby_state]),
    ("smooth_norm, smooth_abs", r"smooth_norm and smooth_abs in the place of norm(?: and abs|, abs and roots of squares)", [lambda d, r, f, m: smooth(d)]),
    ("another first guess", r"another first guess (?:or initial state, away from [^;]+|\([^)]*\))|another first guess(?=, or many)|another first guess|"
     r"a first guess (?:nearer to (?:the answer|what is possible)|with smaller gaps)|states of the first guess that the controls can follow", ANOTHER_GUESS),
    ("solver.restarts", r"(?:, )?or many of them \(solver\.restarts(?:: \{count: 20, spread: 1\})?\)(?:: the motion jumps through an obstacle that it should avoid)?|"
     r"many first guesses \(solver\.restarts: \{count: 20, spread: 1\}\)",
     setting("solver.restarts", {"count": 20, "spread": 1})),
    ("steps of at most ... s", r"(?:or )?steps of at most (\S+) s there, by more knots", [lambda d, r, f, m: stepped(d, float(m[1]))]),
    ("integrator: radau5", r"'integrator: radau5'(?: \([^)]*\)|, stable in steps of any length)", RADAU5),
    ("integrator: rk4", r"'integrator: rk4' \([^)]*\)|(?:or )?an integrator of higher order(?: \(integrator: rk4\))?", RK4),
    ("steps of dt/4", r"steps of dt/4 \([^)]*\)", each(more_knots, 4)),
    ("a smaller dt", r"a smaller dt(?: with contacts\.(\w+)\.baumgarte\.kd: 1/dt)?", [lambda d, r, f, m: stiffer(more_knots(d, 4), m[1])]),
    ("more knots", r"more knots(?: where the motion is fast| \(about \d+ times as many\))?", MORE_KNOTS),
    ("smaller kp and kd", r"smaller gains kp and kd of contacts", each(lambda d, v: put(d, "contacts", {
        n: c | {"baumgarte": scaled(c["baumgarte"], v)} for n, c in d["contacts"].items()}) if d.get("contacts") else None, 0.25)),
    ("look for tiny masses", r"look for tiny masses and inertias \('conddp inspect'\)", []),
    ("bounds where a cost has no least value", r"bounds on controls and states: a cost that is linear or negative may be unbounded below",
     each(lambda d, v: add(d, "constraints", {"bounds": "control", "lower": -v, "upper": v}), 1, 10)),
    ("bounds where expressions are not finite", r"bounds on the states where expressions are not finite", []),
    ("a cost on every control", r"a cost on every control of that knot|give them a cost|a cost on it \('[^']*'\)",
     each(lambda d, v: add(d, "costs", CONTROL | {"weight": v}), 1e-3, 1)),
    ("bounds on a control", r"or bounds \('\{bounds: control, lower: -1, upper: 1\}'\)",
     each(lambda d, v: add(d, "constraints", {"bounds": "control", "lower": -v, "upper": v}), 1)),
    ("wider bounds on the control", r"wider bounds on the control", each(lambda d, v: wider_bounds(d, v, True), 2, 5)),
    ("wider bounds", r"wider bounds", each(wider_bounds, 2, 5)),
    ("more time", r"(?:or )?more time(?: for the motion)?(?! \()", each(more_time, 2, 4)),
    ("--drop", r"or a solve without one constraint \(--drop\) to find the conflict",
     [lambda d, r, f, m, v=v: without_violated(d, r, v) for v in (False, True)]),
    ("a larger initial_penalty", r"(?:where controls without bounds have to become large, )?a larger solver\.augmented_lagrangian\.initial_penalty",
     setting("solver.augmented_lagrangian.initial_penalty", {"times": 100}, {"times": 1e4})),
    ("a larger penalty_factor", r"or a larger penalty_factor beside it", [lambda d, r, f, m: put(put(
        d, "solver.augmented_lagrangian.initial_penalty", {"times": 100}), "solver.augmented_lagrangian.penalty_factor", 100)]),
    ("--solver auto", r"--solver auto, which tries several", setting("solver.name", "auto")),
    ("--solver ipopt", r"--solver ipopt, which (?:has no penalties|a linear cost does not pull away from feasibility)", setting("solver.name", "ipopt")),
    ("bounds by which the cost falls", r"bounds on the states and durations by which the cost falls",
     each(lambda d, v: add(d, "constraints", {"bounds": "state", "lower": -v, "upper": v}), 10)),
    ("larger tolerances", r"a larger (?:(?:, )?solver\.tolerances\.\w+)+ \(the answer is as good as the cost's digits allow\)", [larger_tolerances]),
    ("smaller weights", r"(?:or )?smaller weights of costs that stay large", [lambda d, r, f, m: weights_of(d, 0.01, lambda n, t: n == largest_cost(r))]),
    ("constraints in other units", r"(?:or )?constraints in units in which their multipliers are smaller", []),
    ("hessian: exact", r"exact Hessians \(solver\.hessian: exact\)", setting("solver.hessian", "exact")),
    ("smoother costs", r"smoother costs \(smooth_l1 with a larger epsilon\)|costs(?: and constraints)? that are not smooth", [lambda d, r, f, m: smoother_costs(d)]),
    ("conddp check --derivatives", r"derivatives \('conddp check --derivatives'\)", []),
    ("mu_strategy: adaptive", r"solver\.options: \{mu_strategy: adaptive\}", setting("solver.options", {"mu_strategy": "adaptive"})),
    ("max_iterations", r"more iterations(?: or time)? \(solver\.max_iterations(?:, --max-time)?\)", setting("solver.max_iterations", {"times": 10}, {"times": 100})),
    ("--warm-start", r"(?:, )?or go on from here with --warm-start", [lambda d, r, f, m: (put(d, "solver.max_iterations", {"times": 10}), r.text)]),
    ("contacts that constrain less", r"contacts that constrain less \([^)]*\)", each(lambda d, v: put(d, "contacts", {
        n: c | {"type": v} for n, c in d["contacts"].items()}), "planar", "normal")),
    ("joints that are not locked", r"joints that are not locked", setting("robot.locked_joints", {})),
    ("a posture in which limbs are bent", r"(?:or )?a posture in which limbs are bent", []),
    ("limits at the joints", r"limits at the joints \([^)]*\)", each(lambda d, v: wider_bounds(d, v, True), 2, 5)),
    ("controls or locked_joints", r"controls or locked_joints at joints that springs, rods or closed chains hold on the robot itself", []),
    ("another initial state", r"another initial state", []),
    ("bounds from urdf", r"constraints: \{NAME: (\{[^}]*\})\}", [lambda d, r, f, m: add(
        d, "constraints", {"bounds": re.search(r"bounds: (\w+)", m[0])[1], "from": "urdf"})]),
    ("baumgarte.kd", r"contacts\.(\w+)\.baumgarte: \{kd: (\S+)\}", [lambda d, r, f, m: put(d, f"contacts.{m[1]}.baumgarte.kd", float(m[2]))]),
    ("baumgarte.kp", r"or (?:a larger )?contacts\.(\w+)\.baumgarte\.kp", [
        lambda d, r, f, m, v=v: put(d, f"contacts.{m[1]}.baumgarte.kp", v) for v in (100, 1000)]),
    ("a larger weight of the cone", r"a larger weight of the cost '(\w+)'", [
        lambda d, r, f, m, v=v: put(d, f"costs.{m[1]}.weight", {"times": v}) for v in (10, 1000)]),
    ("a cone at impulses", r"a constraint or cost 'friction_cone' with 'phases: (\[[^\]]*\]|\w+)'", [lambda d, r, f, m, v=v: add(
        d, "constraints" if v == 0 else "costs", cone(f["subject"]) | {"phases": m[1].strip("[]").split(", ")} | ({"weight": v} if v else {}))
        for v in (0, 1000)]),
    ("a cost 'friction_cone'", r"a constraint or cost 'friction_cone' on it", [lambda d, r, f, m, v=v: add(
        d, "constraints" if v == 0 else "costs", cone(f["subject"]) | ({"weight": v} if v else {})) for v in (0, 10, 1000)]),
    ("a constraint 'friction_cone'", r"(?:or )?a constraint 'friction_cone'", [lambda d, r, f, m: add(d, "constraints", cone(f["subject"]))]),
    ("a cone at all knots", r"the (?:constraint|cost) '(\w+)' at all knots", [lambda d, r, f, m: everywhere(d, m[1])]),
    ("a slower touch-down", r"a touch-down with less speed along the ground", []),
    ("nodes: ends", r"'nodes: ends'", [lambda d, r, f, m: put(d, f"constraints.{f['subject']}.nodes", "ends")]),
    ("wider distances", r"(?:or )?wider distances", [lambda d, r, f, m: wider_distance(d, f)]),
    ("more points", r"more points, or a bound on its argument: beyond its points the table is linear", [lambda d, r, f, m: longer_table(d, f)]),
    ("smaller weights of terminal costs", r"smaller weights of terminal costs", each(
        lambda d, v: weights_of(d, v, lambda n, t: n.startswith("terminal/")), 0.1, 0.01)),
    ("control_rate", r"a cost 'control_rate'", each(lambda d, v: add(d, "costs", {"residual": "control_rate", "weight": v * effort(d)}), 1, 10, 100)),
    ("other thrusters", r"thrusters off the center of mass in other directions, or with a torque_ratio", [lambda d, r, f, m: more_thrusters(d)]),
    ("larger weights of all costs", r"larger weights to all costs", each(weights_of, 1e3)),
    ("a smaller tolerance", r"or a smaller solver\.tolerances\.stationarity", setting("solver.tolerances.stationarity", {"times": 1e-2})),
)]

# What diagnoses do not say in every case, tried beside what they say.
UNSPOKEN = [(kind, None, tries) for kind, tries in (
    ("max_iterations", setting("solver.max_iterations", {"times": 10})),
    ("--solver auto", setting("solver.name", "auto")),
    ("--solver ipopt", setting("solver.name", "ipopt")),
)]
UNSPOKEN_OF_FINDINGS = [("more knots", None, MORE_KNOTS)]

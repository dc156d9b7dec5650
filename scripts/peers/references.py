"""What a cost is measured from, at each node."""

import numpy as np
import pinocchio as pin

from robot import require


def node_times(phases):
    steps = [phase["dt"] for phase in phases for _ in range(phase["knots"])]
    return np.concatenate([[0.0], np.cumsum(steps)])


def landing(robot, swing, number, at, start):
    """Where a swing ends that begins at a point; `start` is where the frame is at first."""
    if "landing" in swing:
        return np.array(swing["landing"])
    if "displaced" in swing:
        return robot.displacement(swing["displaced"][number], robot.initial) * start
    return at + swing["step"]


def smooth_swing(robot, problem, cost):
    """Way-points at all nodes of a frame that swings: s² (3 − 2 s) along the line, and above it by
    16 height s² (1 − s)²."""
    swing, phases = cost["swing"], problem["phases"]
    at = robot.placement(robot.frame(cost["frame"]), robot.initial).translation
    start, points, swings_before, first, p = at, {}, [], 0, 0
    while p < len(phases):
        swings, end, knots = phases[p]["name"] in cost["phases"], p, 0
        while end < len(phases) and (phases[end]["name"] in cost["phases"]) == swings:
            knots += phases[end]["knots"]
            end += 1
        if swings:
            to = landing(robot, swing, len(swings_before), at, start)
            swings_before.append(p)
            for k in range(knots + 1):
                s = k / knots
                points[first + k] = at + s * s * (3 - 2 * s) * (to - at)
                points[first + k][2] += 16 * swing["height"] * s * s * (1 - s) ** 2
            at = to
        first, p = first + knots, end
    return points


def weights_over_knots(problem, name):
    """The weight of a running cost at each knot, 0 where it does not count. A phase may have a weight
    of its own; a swing also counts at the knot after its phases, at which the frame touches down, a moment
    that is not multiplied by the time step."""
    cost = problem["costs"][name]
    weights, steps = [], []
    for phase in problem["phases"]:
        steps += [phase["dt"]] * phase["knots"]
        weight = phase["weights"].get(name, cost["weight"])
        weights += [weight if phase["name"] in cost["phases"] else 0.0] * phase["knots"]
    if "swing" in cost:
        weights = [w or before / dt for w, before, dt in zip(weights, [0.0, *weights], steps)]
    return [w if k in cost.get("knots", [k]) else 0.0 for k, w in enumerate(weights)]


def over_nodes(problem, spec):
    """The function of the node that a list of values over time means: its two values around a node and
    the share of the second one."""
    times = node_times(problem["phases"])
    places = spec["times"] if "times" in spec else [times[k] for k in spec["knots"]]

    if len(places) == 1:
        return lambda k: (spec["values"][0], spec["values"][0], 0.0)

    def around(k):
        i = int(np.clip(np.searchsorted(places, times[k], side="right") - 1, 0, len(places) - 2))
        share = (times[k] - places[i]) / (places[i + 1] - places[i])
        return spec["values"][i], spec["values"][i + 1], float(np.clip(share, 0, 1))

    return around


def states(robot, problem, cost):
    """A function of the node for a reference that is a state: between two of them along the geodesic."""
    spec = cost["reference"]
    if not isinstance(spec, dict) or "values" not in spec:
        fixed = robot.state(spec)
        return lambda k: fixed
    around = over_nodes(problem, spec)

    def value(k):
        first, second, share = around(k)
        return robot.between(robot.state(first), robot.state(second), share)
    return value


def vector_values(robot, problem, cost, named, constant):
    """A function of the node for a reference that is a vector. `named` gives it at a state,
    `constant` reads it from the file."""
    if "swing" in cost:
        points = smooth_swing(robot, problem, cost)
        return lambda k: points[k]
    spec = cost["reference"]

    def value(entry):
        return named(robot.state(entry)) if isinstance(entry, str) else constant(entry)

    if not isinstance(spec, dict) or "values" not in spec:
        require(not isinstance(spec, dict) or "file" not in spec, "references from files")
        fixed = value(spec)
        return lambda k: fixed
    around = over_nodes(problem, spec)

    def at_node(k):
        first, second, share = around(k)
        return (1 - share) * value(first) + share * value(second)
    return at_node


def pose(robot, problem, cost, k):
    """A reference pose at node k: a fixed one, or that of a frame which swings and does not turn."""
    frame = robot.frame(cost["frame"])
    if "swing" in cost:
        require("displaced" not in cost["swing"], "swings of a frame that turns")
        turned = robot.placement(frame, robot.initial).rotation
        return pin.SE3(turned, smooth_swing(robot, problem, cost)[k])
    spec = cost["reference"]
    if isinstance(spec, str):
        return robot.placement(frame, robot.state(spec))
    require("values" not in spec and "file" not in spec, "poses that change over time")
    orientation = pin.Quaternion(np.array(spec.get("orientation", [0, 0, 0, 1.0])))
    return pin.SE3(orientation.matrix(), np.array(spec.get("position", [0, 0, 0.0])))

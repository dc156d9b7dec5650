"""Claims about motions, true or false by construction: the self-test of composed_verdicts.py."""

import copy
import math

import numpy
from composed_program import Program
from composed_search import Neighbourhood

LINE = {
    "conddp": 1,
    "name": "line",
    "integrator": "rk4",
    "system": {"states": ["x0", "x1"], "controls": ["u0"], "rate": {"x0": "x1", "x1": "u0"}},
    "initial_state": {"values": {"x0": 0, "x1": 0}},
    "phases": [{"name": "move", "knots": 10, "dt": 0.1}],
    "costs": {"effort": {"residual": "control", "weight": 1}},
    "constraints": {},
    "terminal": {
        "costs": {"goal": {"residual": "state", "reference": [1, 0], "weight": 100}},
        "constraints": {},
    },
}
HANGING = LINE | {
    "system": {
        "states": ["x0", "x1"],
        "controls": ["u0"],
        "rate": {"x0": "x1", "x1": "u0 - 5*sin(x0)"},
    },
    "terminal": {
        "costs": {
            "tip": {"residual": "expression", "rows": ["sin(x0)", "1 + cos(x0)"], "weight": 1e4}
        },
        "constraints": {},
    },
}


def bounded(reach, goal):
    """The line with bounded controls, which has to arrive."""
    document = copy.deepcopy(LINE)
    document["constraints"]["reach"] = {"bounds": "control", "lower": -reach, "upper": reach}
    document["terminal"] = {
        "costs": {},
        "constraints": {"goal": {"residual": "state", "reference": goal}},
    }
    return document


def claim(document, z, status="converged", verdict="local_minimum", cheaper=0.0):
    """What a solution says of a motion."""
    program = Program(document)
    x, u = program.trajectory(z)
    _, gap, distances = program.at(z)
    row = {"gap": gap, "constraint": float(numpy.max(distances))}
    return {
        "status": status,
        "cost": math.fsum(program.at(z)[0]) - cheaper,
        "exit": 0,
        "log": [row],
        "certificate": {"verdict": verdict},
        "trajectory": {"x": x, "u": u},
    }


def moved(document, controls):
    program = Program(document)
    return program.point(program.simulated(controls), controls)


def optimum(document, of_violation=False):
    start = moved(document, [[0.3]] * 10)
    near = Neighbourhood(Program(document), of_violation)
    return near.lowest(start, 50, [0 * start])[1]


def claims():
    """Name, document, feasible guess, claim, and what has to be found."""
    best, rest = optimum(LINE), moved(HANGING, [[0.0]] * 10)
    short = moved(LINE, [[0.95 * u[0]] for u in Program(LINE).trajectory(best)[1]])
    yield "an optimum", LINE, None, claim(LINE, best), []
    yield "a shorter way, as minimum", LINE, None, claim(LINE, short), ["false minimum"]
    yield "a shorter way, as stationary", LINE, None, claim(LINE, short, verdict="stationary"), [
        "false stationary"
    ]
    yield "a saddle, as minimum", HANGING, None, claim(HANGING, rest), ["false minimum"]
    yield "a saddle, as stationary", HANGING, None, claim(HANGING, rest, verdict="stationary"), []
    yield "a saddle, refuted", HANGING, None, claim(HANGING, rest, verdict="not_a_minimum"), []
    yield "an optimum, refuted", LINE, None, claim(LINE, best, verdict="not_a_minimum"), [
        "refuted without descent"
    ]
    yield "another cost", LINE, None, claim(LINE, best, cheaper=1e-3), ["twins differ"]
    opened = best + 1e-6 * (numpy.arange(len(best)) == 4)
    yield "a gap", LINE, None, claim(LINE, opened), ["not feasible"]
    yield from claims_of_constraints()


def claims_of_constraints():
    controls = [[0.2 * math.sin(k)] for k in range(10)]
    end = Program(LINE).simulated(controls)[-1]
    within, beyond = bounded(1, end), bounded(1, [5, 0])
    guess = (Program(LINE).simulated(controls), controls)
    costly = moved(within, [[0.3] for _ in range(10)])
    best = optimum(within)
    yield "within reach", within, guess, claim(within, best), []
    yield "within reach, infeasible", within, guess, claim(
        within, costly, "infeasible", "consistent"
    ), ["false infeasible", "guess lost"]
    yield "missed, as minimum", within, None, claim(within, costly), ["not feasible"]
    least = optimum(beyond, of_violation=True)
    yield "beyond reach", beyond, None, claim(beyond, least, "infeasible", "consistent"), []
    half = moved(beyond, [[0.5] for _ in range(10)])
    yield "beyond reach, early", beyond, None, claim(beyond, half, "infeasible", "consistent"), [
        "false infeasible"
    ]

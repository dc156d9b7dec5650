"""Random optimal-control problems with equations of their own, as documents of problem files. The
same seed gives the same problem. All sizes are about 1, but for the weights."""

import math

from composed_terms import SYSTEMS, Draw, own_cost, pendulum, point, state_cost

SOLVERS = ("auto", "altro", "proxddp", "ipopt", "box_fddp", "auto", "ddp", "fddp")
WITHOUT_ROWS, WITHOUT_BOUNDS = ("box_fddp", "ddp", "fddp"), ("ddp", "fddp")
KINDS = ("plain",) * 3 + ("bounded", "planted", "planted", "shifted", "far", "saddle")
#: Decades of the weights of one problem.
DECADES = ((-2, 2), (-4, 6), (-9, 12))


def in_unit(unit, term):
    """Rows that are so many times as large."""
    limits = {key: term[key] for key in ("upper", "equals") if key in term}
    return {
        **term,
        "rows": [f"{unit}*({row})" for row in term["rows"]],
        **{
            key: [unit * v for v in value] if isinstance(value, list) else unit * value
            for key, value in limits.items()
        },
    }


class Composer:
    """A document and, in `guess`, a motion that satisfies its constraints, where one is known."""

    def __init__(self, seed, simulated):
        draw = self.draw = Draw(seed)
        decades = draw.choice(DECADES)
        self.weight = lambda: draw.size(*decades)
        self.simulated, self.guess = simulated, None
        self.kind = draw.choice(KINDS)
        saddles = (self.hanging, self.obstacle, self.turning_goal)
        saddle = draw.choice(saddles) if self.kind == "saddle" else None
        is_pendulum = saddle in (self.hanging, self.turning_goal)
        system = pendulum if is_pendulum else point if saddle else draw.choice(SYSTEMS)
        rate, m = system(draw)
        self.n, self.m = len(rate), m
        states = [f"x{i}" for i in range(self.n)]
        self.document = {
            "conddp": 1,
            "name": f"composed_{seed}",
            "system": {
                "states": states,
                "controls": [f"u{i}" for i in range(m)],
                "rate": dict(zip(states, rate)),
            },
            "initial_state": {"values": {s: 0 if saddle else draw.number(-1, 1) for s in states}},
            "integrator": draw.choice(("rk4", "rk4", "explicit_euler")),
            "phases": [{"name": "move", "knots": draw.randint(5, 40), "dt": draw.size(-1.7, -0.7)}],
            "costs": {},
            "constraints": {},
            "terminal": {"costs": {}, "constraints": {}},
        }
        (saddle or self.usual)()
        self.document["solver"] = {"name": self.solver(SOLVERS[seed % len(SOLVERS)])}

    def solver(self, name):
        """That of the seed, where it supports the constraints."""
        rows = {**self.document["constraints"], **self.document["terminal"]["constraints"]}
        bounds = rows.pop("reach", None)
        return (
            "altro" if rows and name in WITHOUT_ROWS or bounds and name in WITHOUT_BOUNDS else name
        )

    def usual(self):
        draw, document, n = self.draw, self.document, self.n
        if self.kind != "plain" or draw.random() < 0.3:
            self.bound_controls()
        if "reach" not in document["constraints"] or draw.random() < 0.8:
            document["costs"]["effort"] = {"residual": "control", "weight": self.weight()}
        for costs in (document["costs"], document["terminal"]["costs"]):
            for i in range(draw.randint(0, 2)):
                costs[f"own_{i}"] = draw.choice((own_cost, state_cost))(
                    draw, n, self.weight, "reach" in document["constraints"]
                )
        if self.kind in ("planted", "shifted", "far"):
            self.constrain()
        elif draw.random() < 0.3:
            document["initial_guess"] = {"controls": {"constant": [draw.number(-1, 1)] * self.m}}

    def bound_controls(self):
        reach = self.draw.size(-0.5, 1)
        self.document["constraints"]["reach"] = {
            "bounds": "control",
            "lower": -reach,
            "upper": reach,
        }

    def constrain(self):
        """Rows about a simulated motion, which satisfies them, but for a goal beside or far off."""
        draw, document = self.draw, self.document
        limit = document["constraints"]["reach"]["upper"]
        knots = document["phases"][0]["knots"]
        for shrink in (0.9, 0.3, 0.1, 0.01):
            waves = [
                (shrink * limit * draw.uniform(0, 1), draw.uniform(0, 0.3), draw.uniform(0, 6))
                for _ in range(self.m)
            ]
            u = [[a * math.sin(w * k + p) for a, w, p in waves] for k in range(knots)]
            x = self.simulated(document, u)
            if all(abs(value) < 20 for row in x for value in row):
                break
        else:
            self.kind = "bounded"
            return
        makers = draw.sample((self.state_bounds, self.path, self.goal), draw.randint(1, 3))
        for make in (
            makers if self.kind == "planted" or self.goal in makers else [*makers, self.goal]
        ):
            make(x)
        if draw.random() < 0.2:
            self.write_again()
        if self.kind == "planted":
            self.guess = (x, u)

    def write_again(self):
        """A row twice, the second time in another unit: multipliers are not unique."""
        for block in (self.document["constraints"], self.document["terminal"]["constraints"]):
            for name in ("path", "goal"):
                if name in block and block[name]["residual"] == "expression":
                    block[f"{name}_again"] = in_unit(self.draw.size(-4, 4), block[name])

    def state_bounds(self, x):
        i, margin = self.draw.randrange(self.n), self.draw.size(-2, 0)
        values = [row[i] for row in x]
        limit = (
            {"upper": max(values) + margin}
            if self.draw.random() < 0.5
            else {"lower": min(values) - margin}
        )
        self.document["constraints"]["place"] = {
            "bounds": "state",
            **{side: {f"x{i}": value} for side, value in limit.items()},
        }

    def path(self, x):
        i, margin = self.draw.randrange(self.n), self.draw.size(-2, 0)
        reach = self.document["constraints"]["reach"]["upper"]
        row, upper = self.draw.choice(
            (
                (f"x{i}^2 + u0^2", max(s[i] ** 2 for s in x) + reach**2 * 0.9),
                (f"sin(x{i})*x0", max(math.sin(s[i]) * s[0] for s in x) + margin),
                (f"x{i}^2 + x0", max(s[i] ** 2 + s[0] for s in x) + margin),
            )
        )
        self.document["constraints"]["path"] = {
            "residual": "expression",
            "rows": [row],
            "upper": upper,
        }

    def goal(self, x):
        draw = self.draw
        columns = sorted(draw.sample(range(self.n), draw.randint(1, min(self.n, 2 * self.m))))
        off = {"planted": 0, "shifted": draw.size(-2, 0), "far": draw.size(1, 2)}[self.kind]
        end = [x[-1][i] + draw.signed(0, 1) * off for i in columns]
        rows = {"residual": "state", "columns": [f"x{i}" for i in columns], "reference": end}
        if len(columns) == 1 and draw.random() < 0.3:
            rows = {
                "residual": "expression",
                "rows": [f"x{columns[0]} + x{columns[0]}^3"],
                "equals": [end[0] + end[0] ** 3],
            }
        self.document["terminal"]["constraints"]["goal"] = rows

    def hanging(self):
        """At rest, as far from where the tip shall be as it can."""
        draw, document = self.draw, self.document
        place = {"residual": "expression", "rows": ["sin(x0)", "1 + cos(x0)"]}
        document["costs"]["effort"] = {"residual": "control", "weight": self.weight()}
        document["terminal"]["costs"]["tip"] = {**place, "weight": self.weight()}
        if draw.random() < 0.5:
            document["costs"]["tip"] = {**place, "weight": self.weight()}
        if draw.random() < 0.5:
            self.bound_controls()

    def turning_goal(self):
        """Rows without a derivative where the guess rests: how far the tip is up, or a distance."""
        draw, document = self.draw, self.document
        document["costs"]["effort"] = {"residual": "control", "weight": self.weight()}
        self.bound_controls()
        high = draw.number(0.01, 1.9)
        document["terminal"]["constraints"]["goal"] = draw.choice(
            (
                {"residual": "expression", "rows": ["1 - cos(x0)"], "lower": high},
                {"residual": "expression", "rows": ["1 - cos(x0)"], "equals": [high]},
                {"residual": "expression", "rows": ["x0*x1"], "lower": high},
                {
                    "residual": "state",
                    "columns": ["x0", "x1"],
                    "reference": [0, 0],
                    "at_least": high,
                },
            )
        )

    def obstacle(self):
        """On the way to the goal; the guess goes through its middle."""
        draw, document = self.draw, self.document
        document["costs"]["effort"] = {"residual": "control", "weight": self.weight()}
        document["terminal"]["costs"]["goal"] = {
            "residual": "state",
            "reference": [2, 0],
            "weight": self.weight(),
        }
        if draw.random() < 0.5:
            document["constraints"]["disc"] = {
                "residual": "state",
                "columns": ["x0", "x1"],
                "reference": [1, 0],
                "at_least": draw.number(0.2, 0.6),
            }
        else:
            bump = f"exp(-((x0 - 1)^2 + x1^2)/{draw.number(0.05, 0.3)})"
            document["costs"]["bump"] = {
                "residual": "expression",
                "rows": [bump],
                "weight": self.weight(),
                "activation": draw.choice(("quadratic", "linear")),
            }
        phase = document["phases"][0]
        if draw.random() < 0.7:
            document["initial_guess"] = {
                "states": "interpolate",
                "controls": {"constant": [float(f"{2 / (phase['knots'] * phase['dt']):.3g}"), 0]},
            }

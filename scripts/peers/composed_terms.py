"""Systems, residuals and costs, drawn at random, of which composed_problem.py makes problems."""

import random


class Draw(random.Random):
    """Numbers of few digits, which the text of a file holds exactly."""

    def number(self, low, high):
        return float(f"{self.uniform(low, high):.3g}")

    def size(self, low, high):
        return float(f"{10 ** self.uniform(low, high):.3g}")

    def signed(self, low, high):
        return self.choice((-1, 1)) * self.number(low, high)


def linear(draw):
    n, m = draw.randint(1, 4), draw.randint(1, 2)
    fast = draw.choice((1, 1, 4))
    rows = [
        " + ".join(
            [f"{draw.number(-fast, fast)}*x{j}" for j in range(n)]
            + [f"{draw.number(-1, 1)}*u{j}" for j in range(m)]
        )
        for _ in range(n)
    ]
    return [f"{row} + u{i % m}" for i, row in enumerate(rows)], m


def chain(draw):
    """Integrators one behind the other, a nonlinear term at the last."""
    n = draw.randint(1, 4)
    term = draw.choice(("sin(x0)", "x0^3", f"x{n - 1}*smooth_abs(x{n - 1}, 0.1)", "x0"))
    return [f"x{i + 1}" for i in range(n - 1)] + [f"u0 + {draw.number(-1, 1)}*{term}"], 1


def pendulum(draw):
    return ["x1", f"u0 - {draw.number(1, 10)}*sin(x0) - {draw.number(0, 0.5)}*x1"], 1


def two_pendulums(draw):
    m, c = draw.randint(1, 2), draw.number(0.5, 3)
    return [
        "x2",
        "x3",
        f"u0 - {draw.number(1, 5)}*sin(x0) + {c}*sin(x1 - x0)",
        f"{'u1' if m == 2 else '0'} - {draw.number(1, 5)}*sin(x1) - {c}*sin(x1 - x0)",
    ], m


def bilinear(draw):
    n = draw.randint(1, 3)
    return [
        f"{draw.number(-1, 1)}*x{i} + "
        f"u0*({draw.number(-1, 1)}*x{(i + 1) % n} + {draw.number(-1, 1)})"
        for i in range(n)
    ], 1


def products(draw):
    return [
        f"{draw.number(-1, 1)}*x0 + {draw.number(-1, 1)}*x0*x1 + u0",
        f"{draw.number(-1, 1)}*x0*x1 - {draw.number(0, 1)}*x1 + {draw.number(0, 0.5)}*u0*x0",
    ], 1


def drag(draw):
    c = draw.number(0.1, 2)
    return [
        "x2",
        "x3",
        f"u0 - {c}*x2*smooth_norm([x2, x3], 0.1)",
        f"u1 - {c}*x3*smooth_norm([x2, x3], 0.1)",
    ], 2


def unicycle(_):
    return ["u0*cos(x2)", "u0*sin(x2)", "u1"], 2


def point(_):
    return ["u0", "u1"], 2


SYSTEMS = (linear, chain, pendulum, two_pendulums, bilinear, products, drag, unicycle)


def activation(draw):
    kind = draw.choice(("quadratic", "smooth_l1", "smooth_l2", "quadratic_barrier", "linear"))
    if kind == "quadratic_barrier":
        return {"kind": kind, "lower": draw.number(-1, 0), "upper": draw.number(0, 1)}
    return {"kind": kind, "epsilon": draw.size(-5, 0)} if kind.startswith("smooth") else kind


def own_cost(draw, n, weight, is_bounded):
    """A residual of its own. Linear costs are bounded where controls are not: else there is no
    minimum."""
    i, j, a = draw.randrange(n), draw.randrange(n), draw.number(-1, 1)
    kind = activation(draw)
    rows = [f"sin({a}*x{i} - x{j})", f"tanh(x{i} - {a})", f"cos(x{i})"]
    if kind == "linear" and is_bounded:
        rows += [f"-x{i}^2", f"x{i}", f"x{i}*x{j}"]
    if kind != "linear":
        rows += [f"x{i}*x{j} - {a}", f"x{i} - {a}", f"x{i}^2 + 0.5*x{j} - {a}"]
    return {
        "residual": "expression",
        "rows": draw.sample(rows, draw.randint(1, 2)),
        "weight": weight(),
        "activation": kind,
    }


def state_cost(draw, n, weight, _):
    columns = sorted(draw.sample(range(n), draw.randint(1, n)))
    return {
        "residual": "state",
        "columns": [f"x{i}" for i in columns],
        "reference": [draw.number(-1, 1) for _ in columns],
        "weight": weight(),
    }

"""Whether a trajectory solves a problem: the check that judges the answers of all tools alike.

It evaluates states and controls in Crocoddyl's shooting problem and uses no figure of a solver. What
counts is the decrease: by how much the cost falls in a step to the minimum of its quadratic model (a
Riccati sweep with Gauss-Newton Hessians) in which controls at a bound that would leave it are held.
It is the distance to a local minimum in units of the cost, whatever the coordinates.

It also measures the gradient of the cost in the controls by an adjoint pass,

    p_N = Lx_N,    g_k = Lu_k + Fu_k' p_{k+1},    p_k = Lx_k + Fx_k' p_{k+1}

in its projected form u - P(u - g), where P clamps to the bounds. On a robot that stands, p grows with
the unstable motion: the gradient may be 1e-3 where the decrease is 1e-11. So it is reported, but does
not count.
"""

import numpy as np

#: Part of the keys of results. Raise it where a figure is measured in another way.
VERSION = 1
GAP = 1e-6           # of the dynamics and of the initial state, largest entry
BOUND = 1e-9         # by which a control may exceed its bound
DECREASE = 1e-7      # of the cost by a model step, over max(1, cost)
GRADIENT = 1e-4      # projected, over its scale; for information


def adjoint_gradients(problem):
    """g_k of every knot; derivatives are those of the last calcDiff."""
    p = problem.terminalData.Lx.copy()
    gradients = []
    for data in reversed(list(problem.runningDatas)):
        gradients.append(data.Lu + data.Fu.T @ p)
        p = data.Lx + data.Fx.T @ p
    return gradients[::-1]


def model_decrease(problem, us):
    """What a step to the minimum of the quadratic model gains; derivatives are those of the last
    calcDiff. Infinite where the model has no minimum."""
    last = problem.terminalData
    p, P, decrease = last.Lx.copy(), last.Lxx.copy(), 0.0
    for model, data, u in zip(reversed(list(problem.runningModels)),
                              reversed(list(problem.runningDatas)), reversed(us)):
        Qu, Quu = data.Lu + data.Fu.T @ p, data.Luu + data.Fu.T @ P @ data.Fu
        Qux = data.Lxu.T + data.Fu.T @ P @ data.Fx
        lower, upper = bounds(model)
        free = ~((u <= lower + BOUND) & (Qu > 0) | (u >= upper - BOUND) & (Qu < 0))
        try:
            root = np.linalg.cholesky(Quu[np.ix_(free, free)])
        except np.linalg.LinAlgError:
            return np.inf
        step, gains = np.linalg.solve(root, Qu[free]), np.linalg.solve(root, Qux[free])
        decrease += step @ step / 2
        p = data.Lx + data.Fx.T @ p - gains.T @ step
        P = data.Lxx + data.Fx.T @ P @ data.Fx - gains.T @ gains
        P = (P + P.T) / 2
    return decrease


def check(problem, xs, us):
    """Cost and violations of a trajectory; `scale` is the largest entry of Lu, at least 1."""
    if not (np.isfinite(xs).all() and np.isfinite(us).all()):
        return None
    xs, us = list(np.array(xs)), list(np.array(us))
    cost = problem.calc(xs, us)
    problem.calcDiff(xs, us)
    state = problem.runningModels[0].state
    gaps = [np.abs(state.diff(xs[0], problem.x0)).max()]
    gaps += [np.abs(state.diff(after, data.xnext)).max()
             for data, after in zip(problem.runningDatas, xs[1:])]
    bound = gradient = 0.0
    scale = 1.0
    for model, data, u, g in zip(problem.runningModels, problem.runningDatas, us,
                                 adjoint_gradients(problem)):
        lower, upper = bounds(model)
        bound = max(bound, (lower - u).max(), (u - upper).max())
        gradient = max(gradient, np.abs(u - np.clip(u - g, lower, upper)).max())
        scale = max(scale, np.abs(data.Lu).max())
    found = {"cost": cost, "gap": max(gaps), "bound": bound, "gradient": gradient, "scale": scale,
             "decrease": model_decrease(problem, us)}
    found = {name: float(value) for name, value in found.items()}
    finite = np.isfinite([found[name] for name in ("cost", "gap", "gradient")]).all()
    return found if finite else None


def bounds(model):
    if not model.has_control_limits:
        return np.full(model.nu, -np.inf), np.full(model.nu, np.inf)
    return model.u_lb, model.u_ub


def is_solved(found):
    """Whether the check accepts what it found."""
    return (found is not None and found["gap"] <= GAP and found["bound"] <= BOUND
            and found["decrease"] <= DECREASE * max(1.0, abs(found["cost"])))


def has_small_gradient(found):
    return found["gradient"] <= GRADIENT * found["scale"]

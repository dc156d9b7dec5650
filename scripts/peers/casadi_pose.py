"""Poses as conddp keeps them, for CasADi: a position and a unit quaternion whose real part is last,
moved and compared by twists in their own frame (linear, angular)."""

import math

import casadi

#: Terms of the series in a squared angle: exact to rounding below half a radian.
TERMS = 7


def product(a, b):
    """Of quaternions."""
    v, w = a[:3], b[:3]
    return casadi.vertcat(a[3] * w + b[3] * v + casadi.cross(v, w), a[3] * b[3] - casadi.dot(v, w))


def rotation(q):
    """The matrix of a unit quaternion."""
    x = casadi.skew(q[:3])
    return casadi.DM.eye(3) + 2 * q[3] * x + 2 * x @ x


def series(t, first):
    """Sum of (-t)^k / (2k + first)!."""
    total = 0
    for k in reversed(range(TERMS)):
        total = 1 / math.factorial(2 * k + first) - t * total
    return total


def moved(pose, twist):
    """pose exp(twist), for small twists."""
    v, w = twist[:3], twist[3:6]
    t = casadi.dot(w, w)
    wv = casadi.cross(w, v)
    step = v + series(t, 2) * wv + series(t, 3) * casadi.cross(w, wv)
    turn = casadi.vertcat(series(t / 4, 1) * w / 2, series(t / 4, 0))
    return casadi.vertcat(pose[:3] + rotation(pose[3:7]) @ step, product(pose[3:7], turn))


def rate_of_twist(twist, rate):
    """Derivative of a small twist m at which exp(m) moves with a rate: ad/(1 - exp(-ad)) as a series,
    to 1e-10 below half a radian."""

    def ad(m):
        return casadi.vertcat(casadi.cross(twist[3:6], m[:3]) + casadi.cross(twist[:3], m[3:6]),
                              casadi.cross(twist[3:6], m[3:6]))

    once = ad(rate)
    total, power = rate + once / 2, once
    for factor in (1 / 12, -1 / 720, 1 / 30240, -1 / 1209600):
        power = ad(power)
        total += factor * power
        power = ad(power)
    return total


def between(origin, pose):
    """The twist that moves a numeric pose to another one, less than half a turn away."""
    turn = product(casadi.vertcat(-origin[3:6], origin[6]), pose[3:7])
    turn = casadi.if_else(turn[3] < 0, -turn, turn)
    v, real = turn[:3], turn[3]
    squared = casadi.dot(v, v)
    small = squared < 1e-4
    length = casadi.sqrt(casadi.if_else(small, 1, squared))
    s = squared / casadi.if_else(small, real, 1) ** 2
    near = 2 / casadi.if_else(small, real, 1) * (1 - s * (1 / 3 - s * (1 / 5 - s * (1 / 7 - s / 9))))
    w = casadi.if_else(small, near, 2 * casadi.atan2(length, real) / length) * v
    p = rotation(origin[3:7]).T @ (pose[:3] - origin[:3])
    # (1 - θ/2 cot(θ/2)) / θ², a series near zero
    t = casadi.dot(w, w)
    close = t < 0.01
    half = casadi.sqrt(casadi.if_else(close, 1, t)) / 2
    at_zero = 1 / 12 + t * (1 / 720 + t * (1 / 30240 + t * (1 / 1209600 + t / 47900160)))
    factor = casadi.if_else(close, at_zero, (1 - half / casadi.tan(half)) / (4 * half * half))
    wp = casadi.cross(w, p)
    return casadi.vertcat(p - wp / 2 + factor * casadi.cross(w, wp), w)

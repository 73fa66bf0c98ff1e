"""Solutions without closed form: python3 tabulated.py > tabulated.csv

Gragg's method, the explicit midpoint rule extrapolated 20 times, in 60-digit arithmetic with two step sizes; what is
printed, 25 digits, is what the two have in common.
"""

import math

from mpmath import cos, mp, mpf, nstr, sin

mp.dps = 60
COLUMNS = 20


def double_pendulum(t, y):
    """Hamilton's equations, from the inverse mass matrix."""
    q1, q2, p1, p2 = y
    s, c = sin(q1 - q2), cos(q1 - q2)
    v1, v2 = (p1 - c * p2) / (1 + s * s), (2 * p2 - c * p1) / (1 + s * s)
    return [v1, v2, -s * v1 * v2 - 2 * sin(q1), s * v1 * v2 - sin(q2)]


def spherical_pendulum(t, y):
    """The multiplier is eliminated by the second derivative of |q|^2."""
    q, p = y[:3], y[3:]
    mu = (sum(x * x for x in p) - q[2]) / sum(x * x for x in q)
    return [*p, -mu * q[0], -mu * q[1], -mu * q[2] - 1]


def charged_particle(t, s):
    """v = p - A and dp/dt = grad(v . A) - grad(r^4/4), A = (1/2 + r^2/4)(-y, x)."""
    x, y, px, py = s
    r2 = x * x + y * y
    a = mpf(1) / 2 + r2 / 4
    vx, vy = px + a * y, py - a * x
    swirl = (x * vy - y * vx) / 2
    return [vx, vy, swirl * x + a * vy - r2 * x, swirl * y - a * vx - r2 * y]


# Name: times, initial state, right-hand side. Parameters and initial states are the problems' defaults, rounded to doubles.
PROBLEMS = {
    "damped-pendulum": (
        [0.5, 1, 1.5, 2, 10],
        [1, 0],
        lambda t, v: [v[1], -sin(v[0]) - mpf(0.2) * v[1]],
    ),
    "van-der-pol": (
        [0.5, 1, 1.5, 2],
        [2, 0],
        lambda t, v: [v[1], (1 - v[0] ** 2) * v[1] - v[0]],
    ),
    "asymmetric-pendulum": (
        [0.5, 1, 1.5, 2],
        [0, 2.5],
        lambda t, v: [v[1], -sin(v[0]) - mpf(0.4) * cos(2 * v[0])],
    ),
    "double-pendulum": ([0.5, 1, 1.5, 2, 5], [1, 2, 0, 0], double_pendulum),
    "spherical-pendulum": (
        [0.5, 1, 1.5, 2, 10],
        [math.sin(1), 0, -math.cos(1), 0, math.sin(1), 0],
        spherical_pendulum,
    ),
    "henon-heiles": (
        [0.5, 1, 1.5, 2, 10],
        [0.1, 0, 0, 0.5],
        lambda t, s: [s[2], s[3], -s[0] - 2 * s[0] * s[1], -s[1] - s[0] ** 2 + s[1] ** 2],
    ),
    "charged-particle": (
        [0.5, 1, 1.5, 2, 10],
        [0.8, 0, 0, 1 + (0.5 + 0.25 * (0.8 * 0.8)) * 0.8],
        charged_particle,
    ),
}


def midpoint(rhs, t, y, h, n):
    """The explicit midpoint rule with n steps over [t, t + h], n even: its error is a series in (h/n)^2."""
    d = h / n
    before, now = y, [a + d * f for a, f in zip(y, rhs(t, y))]
    for k in range(1, n):
        before, now = now, [a + 2 * d * f for a, f in zip(before, rhs(t + k * d, now))]
    return now


def extrapolated(rhs, t, y, h):
    """Aitken and Neville's scheme in (h/n)^2 to zero, of order 2 COLUMNS."""
    row = []
    for j in range(1, COLUMNS + 1):
        new = [midpoint(rhs, t, y, h, 2 * j)]
        for k, older in enumerate(row, 1):
            ratio = mpf(j * j) / ((j - k) * (j - k)) - 1
            new.append([a + (a - b) / ratio for a, b in zip(new[-1], older)])
        row = new
    return row[-1]


def solve(times, start, rhs, h):
    t, y, states = mpf(0), [mpf(x) for x in start], []
    for end in times:
        n = int(mp.ceil((mpf(end) - t) / h))
        d = (mpf(end) - t) / n
        for k in range(n):
            y = extrapolated(rhs, t + k * d, y, d)
        t = mpf(end)
        states.append(y)
    return states


print("# Solutions of the default problems; written by tabulated.py, mpmath 1.3.0, 60 digits; one row per component")
print("problem,t,component,value")
for name, (times, start, rhs) in PROBLEMS.items():
    coarse, fine = (solve(times, start, rhs, mpf(h)) for h in (0.125, 0.0625))
    for t, low, high in zip(times, coarse, fine):
        for i, (a, b) in enumerate(zip(low, high)):
            assert abs(a - b) < mpf(10) ** -27 * (1 + abs(b)), (name, t, i, a, b)
            print(f"{name},{t},{i},{nstr(b, 25)}")

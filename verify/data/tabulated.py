"""Solutions without closed form, in 40-digit arithmetic: python3 tabulated.py > tabulated.csv

Taylor's method of mpmath (odefun) at two precisions; what is printed, 25 digits, is what the two have in common.
"""

from mpmath import cos, mp, mpf, nstr, odefun, sin

# Name: times, initial state, right-hand side. Parameters are the problems' defaults, as decimals rounded to doubles.
PROBLEMS = {
    "damped-pendulum": (
        [0.5, 1, 1.5, 2],
        [1, 0],
        lambda t, v: [v[1], -sin(v[0]) - mpf(0.2) * v[1]],
    ),
    "van-der-pol": (
        [0.5, 1, 1.5, 2],
        [2, 0],
        lambda t, v: [v[1], (1 - v[0] ** 2) * v[1] - v[0]],
    ),
}


def solve(times, start, rhs, digits):
    mp.dps = digits
    flow = odefun(rhs, 0, [mpf(x) for x in start])
    return [[+x for x in flow(mpf(t))] for t in times]


print("# Solutions of the default problems; written by tabulated.py, mpmath 1.3.0, 40 digits; one row per component")
print("problem,t,component,value")
for name, (times, start, rhs) in PROBLEMS.items():
    coarse, fine = (solve(times, start, rhs, digits) for digits in (32, 40))
    for t, low, high in zip(times, coarse, fine):
        for i, (a, b) in enumerate(zip(low, high)):
            assert abs(a - b) < mpf(10) ** -27 * (1 + abs(b)), (name, t, i, a, b)
            print(f"{name},{t},{i},{nstr(b, 25)}")

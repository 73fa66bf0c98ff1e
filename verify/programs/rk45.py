"""SciPy's fifth-order Runge-Kutta method with steps of one size, as `verify order --program` runs it:

    verify order --problem logistic --program 'python3 rk45.py' --expect 5 --band 0.2
"""

import argparse

from scipy.integrate import solve_ivp

PROBLEMS = {
    "logistic": (["v"], [0.1], {"lambda": 1.0}, lambda t, v, p: [p["lambda"] * v[0] * (1 - v[0])]),
    "van-der-pol": (["x", "y"], [2.0, 0.0], {"mu": 1.0}, lambda t, v, p: [v[1], p["mu"] * (1 - v[0] ** 2) * v[1] - v[0]]),
}

parser = argparse.ArgumentParser()
parser.add_argument("--problem", choices=PROBLEMS, required=True)
parser.add_argument("--h", type=float, required=True)
parser.add_argument("--t-end", type=float, required=True)
parser.add_argument("--set", action="append", default=[])
arguments = parser.parse_args()

names, start, parameters, f = PROBLEMS[arguments.problem]
parameters = parameters | {name: float(value) for name, value in (pair.split("=") for pair in arguments.set)}
# Tolerances that nothing exceeds leave the steps as long as they may be.
run = solve_ivp(
    lambda t, v: f(t, v, parameters),
    (0.0, arguments.t_end),
    start,
    method="RK45",
    first_step=arguments.h,
    max_step=arguments.h,
    rtol=1e6,
    atol=1e6,
)
print(",".join(["t", *names]))
for t, state in zip(run.t, run.y.T):
    print(",".join(repr(float(x)) for x in [t, *state]))

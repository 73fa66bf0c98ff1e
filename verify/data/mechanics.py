"""Motions of the pendulum and of Kepler's problem in 40-digit arithmetic: python3 mechanics.py > mechanics.csv

The pendulum is integrated by Taylor series of its differential equation, which knows nothing of elliptic functions;
Kepler's equation is solved by bisection and secants. Parameters and times are the doubles nearest to the decimals printed;
q and p are printed to 25 digits.
"""

from mpmath import cos, findroot, mp, mpf, nstr, odefun, sin, sqrt

mp.dps = 40


def pendulum(q0, p0, times):
    solution = odefun(lambda t, y: [y[1], -sin(y[0])], 0, [mpf(q0), mpf(p0)])
    return [solution(mpf(t)) for t in times]


def kepler(e, t):
    e, t = mpf(e), mpf(t)
    anomaly = findroot(lambda x: x - e * sin(x) - t, (t - e, t + e), solver="anderson") if e else t
    minor, rate = sqrt(1 - e * e), 1 / (1 - e * cos(anomaly))
    return cos(anomaly) - e, minor * sin(anomaly), -sin(anomaly) * rate, minor * cos(anomaly) * rate


print("# pendulum: a = q0, b = p0; kepler: a = eccentricity; written by mechanics.py, mpmath 1.3.0, 40 digits")
print("problem,a,b,t,state")
for q0, p0 in [(2, 0), (-1, 0.5), (0.1, 0), (3.1, 0), (0, 1.99), (0, 2.01), (7, 2.5), (0.5, -3)]:
    times = [0.1, 1, 2, 7.5]
    for t, (q, p) in zip(times, pendulum(q0, p0, times)):
        print(f"pendulum,{q0},{p0},{t},{nstr(q, 25)} {nstr(p, 25)}")
for e in [0, 0.3, 0.6, 0.95]:
    for t in [0.01, 1, 2, 3.1, 5, 50]:
        print(f"kepler,{e},,{t},{' '.join(nstr(x, 25) for x in kepler(e, t))}")

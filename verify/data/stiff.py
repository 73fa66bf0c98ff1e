"""Solutions of the stiff and of the celestial problems, and of Burgers' equation on a grid, in 36-digit arithmetic: python3 stiff.py > stiff.csv

Radau IIA collocation of 9 stages, order 17. The last Legendre coefficient of the collocated rate controls the step; the
error at the end of a step is about its square. Every problem is solved at two tolerances, the finer one is printed, with
21 digits, and both must agree to 18 relative to each component. With names as arguments, only those are solved.
"""

import sys

from mpmath import inf, legendre, matrix, mp, mpf, nstr, polyroots, taylor

mp.dps = 36
STAGES = 9


def radau(s):
    """Nodes and matrix of Radau IIA, and the row that maps stage rates to their last Legendre coefficient."""
    low, high = taylor(lambda x: legendre(s - 1, 2 * x - 1), 0, s - 1), taylor(lambda x: legendre(s, 2 * x - 1), 0, s)
    low.append(mpf(0))
    c = sorted(x.real for x in polyroots([h - l for h, l in zip(high[::-1], low[::-1])], maxsteps=200, extraprec=200))
    powers = matrix(s, s)
    for i in range(s):
        for j in range(s):
            powers[i, j] = c[i] ** j
    inverse = powers**-1
    integrals = matrix(s, s)
    for i in range(s):
        for j in range(s):
            integrals[i, j] = c[i] ** (j + 1) / (j + 1)
    # A polynomial's leading monomial coefficient over that of the Legendre polynomial of the same degree.
    leading = taylor(lambda x: legendre(s - 1, 2 * x - 1), 0, s - 1)[-1]
    return c, (integrals * inverse).tolist(), [inverse[s - 1, j] / leading for j in range(s)], inverse.tolist()


C, A, LAST, COEFFICIENTS = radau(STAGES)


def factor(a):
    """LU factors of a list of rows, with partial pivoting."""
    n, rows = len(a), list(range(len(a)))
    for k in range(n):
        p = max(range(k, n), key=lambda i: abs(a[i][k]))
        a[k], a[p], rows[k], rows[p] = a[p], a[k], rows[p], rows[k]
        for i in range(k + 1, n):
            if a[i][k]:
                m = a[i][k] = a[i][k] / a[k][k]
                row, pivot = a[i], a[k]
                for j in range(k + 1, n):
                    if pivot[j]:
                        row[j] -= m * pivot[j]
    return a, rows


def solve(factors, b):
    a, rows = factors
    x = [b[i] for i in rows]
    for i in range(len(x)):
        x[i] -= sum(a[i][j] * x[j] for j in range(i))
    for i in reversed(range(len(x))):
        x[i] = (x[i] - sum(a[i][j] * x[j] for j in range(i + 1, len(x)))) / a[i][i]
    return x


def step(rhs, jacobian, y, h, guess):
    """Increments and rates at the stages, or None where the iteration does not converge. Without a Jacobian: fixed points."""
    n, s = len(y), STAGES
    z = guess or [[mpf(0)] * n for _ in range(s)]
    factors, last = None, inf
    for _ in range(60):
        f = [rhs([a + b for a, b in zip(y, row)]) for row in z]
        new = [[h * sum(A[i][k] * f[k][j] for k in range(s)) for j in range(n)] for i in range(s)]
        residual = [new[i][j] - z[i][j] for i in range(s) for j in range(n)]
        if jacobian:
            if factors is None or last > mpf("1e-6"):
                stages = [jacobian([a + b for a, b in zip(y, row)]) for row in z]
                big = [[mpf(i == k and j == l) - h * A[i][k] * stages[k][j][l] for k in range(s) for l in range(n)]
                       for i in range(s) for j in range(n)]
                factors = factor(big)
            residual = solve(factors, residual)
        z = [[z[i][j] + residual[i * n + j] for j in range(n)] for i in range(s)]
        scale = [max(abs(y[j]), max(abs(row[j]) for row in z)) or mpf(1) for j in range(n)]
        change = max(abs(residual[i * n + j]) / scale[j] for i in range(s) for j in range(n))
        if change < mpf(10) ** (4 - mp.dps):
            return z, [rhs([a + b for a, b in zip(y, row)]) for row in z], scale
        if change > 2 * last and last < inf:
            return None
        last = change
    return None


def integrate(rhs, jacobian, start, times, tolerance):
    y, t, h, out = [mpf(x) for x in start], mpf(0), mpf("1e-6"), []
    polynomial = None
    for end in times:
        end = mpf(end)
        while t < end:
            take = min(h, end - t)
            guess = None
            if polynomial and take <= 2 * polynomial[0]:
                old, coefficients = polynomial
                guess = []
                for c in C:
                    x = 1 + c * take / old
                    # The primitive of the last step's rate, from its end on.
                    guess.append([old * sum(k[m] * (x ** (m + 1) - 1) / (m + 1) for m in range(STAGES))
                                  for k in coefficients])
            found = step(rhs, jacobian, y, take, guess) or (guess and step(rhs, jacobian, y, take, None))
            if not found:
                h, polynomial = take / 4, None
                continue
            z, f, scale = found
            error = max(abs(take * sum(w * k[j] for w, k in zip(LAST, f))) / scale[j] for j in range(len(y)))
            factor_ = min(mpf(3), max(mpf("0.2"), mpf("0.9") * (tolerance / (error + mpf("1e-60"))) ** (mpf(1) / STAGES)))
            if error > tolerance:
                h = take * factor_
                continue
            t = end if take == end - t else t + take
            y = [a + b for a, b in zip(y, z[-1])]
            polynomial = (take, [[sum(COEFFICIENTS[m][i] * f[i][j] for i in range(STAGES)) for m in range(STAGES)]
                                 for j in range(len(y))])
            h = max(h, take * factor_) if take < h else take * factor_
        out.append(y)
    return out


def robertson(y):
    a, b, c = mpf("0.04") * y[0], mpf(10) ** 4 * y[1] * y[2], 3 * mpf(10) ** 7 * y[1] ** 2
    return [b - a, a - b - c, c]


def robertson_jacobian(y):
    a, b, c, d = mpf("0.04"), mpf(10) ** 4 * y[2], mpf(10) ** 4 * y[1], 6 * mpf(10) ** 7 * y[1]
    return [[-a, b, c], [a, -b - d, -c], [0, d, 0]]


def oregonator(y):
    s, w, q = mpf("77.27"), mpf("0.161"), mpf("8.375e-6")
    return [s * (y[1] + y[0] * (1 - q * y[0] - y[1])), (y[2] - (1 + y[0]) * y[1]) / s, w * (y[0] - y[2])]


def oregonator_jacobian(y):
    s, w, q = mpf("77.27"), mpf("0.161"), mpf("8.375e-6")
    return [[s * (1 - 2 * q * y[0] - y[1]), s * (1 - y[0]), 0], [-y[1] / s, -(1 + y[0]) / s, 1 / s], [w, 0, -w]]


def hires(y):
    """Schäfer (1975) as printed in the test set; the rates are decimals."""
    d = mpf
    r = 280 * y[5] * y[7]
    return [
        -d("1.71") * y[0] + d("0.43") * y[1] + d("8.32") * y[2] + d("0.0007"),
        d("1.71") * y[0] - d("8.75") * y[1],
        -d("10.03") * y[2] + d("0.43") * y[3] + d("0.035") * y[4],
        d("8.32") * y[1] + d("1.71") * y[2] - d("1.12") * y[3],
        -d("1.745") * y[4] + d("0.43") * (y[5] + y[6]),
        -r + d("0.69") * y[3] + d("1.71") * y[4] - d("0.43") * y[5] + d("0.69") * y[6],
        r - d("1.81") * y[6],
        d("1.81") * y[6] - r,
    ]


def hires_jacobian(y):
    d = mpf
    a, b = 280 * y[7], 280 * y[5]
    return [
        [-d("1.71"), d("0.43"), d("8.32"), 0, 0, 0, 0, 0],
        [d("1.71"), -d("8.75"), 0, 0, 0, 0, 0, 0],
        [0, 0, -d("10.03"), d("0.43"), d("0.035"), 0, 0, 0],
        [0, d("8.32"), d("1.71"), -d("1.12"), 0, 0, 0, 0],
        [0, 0, 0, 0, -d("1.745"), d("0.43"), d("0.43"), 0],
        [0, 0, 0, d("0.69"), d("1.71"), -a - d("0.43"), d("0.69"), -b],
        [0, 0, 0, 0, 0, a, -d("1.81"), b],
        [0, 0, 0, 0, 0, -a, d("1.81"), -b],
    ]


def van_der_pol(mu):
    return (lambda y: [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]],
            lambda y: [[0, 1], [-2 * mu * y[0] * y[1] - 1, mu * (1 - y[0] ** 2)]])


def pleiades(y):
    """Seven stars of masses 1…7 in a plane: x, y, ẋ, ẏ."""
    x, rate = y[:14], list(y[14:]) + [mpf(0)] * 14
    for i in range(7):
        for j in range(i):
            dx, dy = x[j] - x[i], x[7 + j] - x[7 + i]
            d2 = dx * dx + dy * dy
            inverse = 1 / (d2 * mp.sqrt(d2))
            for a, m in ((i, j + 1), (j, -(i + 1))):
                rate[14 + a] += m * dx * inverse
                rate[21 + a] += m * dy * inverse
    return rate


def burgers(y):
    """Central differences in 8 cells; the last unknown is the time, of which the ends of the front depend."""
    n, nu, t = 8, mpf("0.1"), y[-1]
    u = [front(0, t), *y[:-1], front(1, t)]
    return [n * (u[i - 1] ** 2 - u[i + 1] ** 2) / 4 + nu * n * n * (u[i - 1] - 2 * u[i] + u[i + 1])
            for i in range(1, n)] + [mpf(1)]


def front(x, t):
    return mpf("0.5") - mpf("0.5") * mp.tanh(mpf("2.5") * (x - mpf("0.25") - t / 2))


STARS = "3 3 -1 -3 2 -2 2 3 -3 2 0 0 -4 4 0 0 0 0 0 1.75 -1.5 0 0 0 -1.25 1 0 0"

# Name and settings: times, initial state, right-hand side, Jacobian.
PROBLEMS = {
    "robertson": (["0.001953125", "0.003", "0.1", "0.2", "0.3", "0.4", 40, 10**11], [1, 0, 0], robertson, robertson_jacobian),
    "oregonator": ([0.0625, 0.5, 1, 1.5, 2, 360], [1, 2, 3], oregonator, oregonator_jacobian),
    "van-der-pol mu=1000": ([2000], [2, 0], *van_der_pol(1000)),
    "hires": ([0.25, 0.5, 1, 1.5, 2, 5, "321.8122"], [1, 0, 0, 0, 0, 0, 0, "0.0057"], hires, hires_jacobian),
    "burgers cells=8": ([0.125, 0.25, 0.5, 0.75, 1], [front(mpf(i) / 8, 0) for i in range(1, 8)] + [0], burgers, None),
    "pleiades": ([0.25, 0.5, 0.75, 1, 3], STARS.split(), pleiades, None),
}

if __name__ == "__main__":
    print("# Solutions of the problems with these settings; written by stiff.py, mpmath 1.3.0, 36 digits")
    print("problem,t,component,value")
    for name, (times, start, rhs, jacobian) in PROBLEMS.items():
        if sys.argv[1:] and name.split()[0] not in sys.argv[1:]:
            continue
        coarse, fine = (integrate(rhs, jacobian, start, times, mpf(tol)) for tol in ("1e-11", "1e-13"))
        for t, low, high in zip(times, coarse, fine):
            if name.startswith("burgers"):
                low, high = low[:-1], high[:-1]
            for i, (a, b) in enumerate(zip(low, high)):
                assert abs(a - b) <= mpf(10) ** -18 * abs(b), (name, t, i, nstr(a, 25), nstr(b, 25))
                print(f"{name},{t},{i},{nstr(b, 21)}", flush=True)

"""Start-up Poiseuille flow with gamma = 2 in 60-digit arithmetic: python3 poiseuille-series.py > poiseuille-series.csv

The eigenfunction series in y, Eq. (34), summed until its terms fall below 1e-55, is held to 1e-22 against the inverse
(Talbot's method) of the Laplace transform gamma/s^2 (1 - cosh(y sqrt s)/cosh(sqrt s)). y and t are the doubles nearest to
the decimals printed; u is printed to 25 digits.
"""

from mpmath import cos, cosh, exp, invertlaplace, mp, mpf, nstr, pi, sqrt

mp.dps = 60
GAMMA = 2


def series(y, t):
    total, k = mpf(0), 0
    while True:
        mu = (k + mpf(1) / 2) * pi
        decay = exp(-mu * mu * t)
        if decay < mpf(10) ** -55:
            return GAMMA * ((1 - y * y) / 2 - total)
        total += 2 * (-1) ** k * cos(mu * y) * decay / mu**3
        k += 1


def laplace(y, t):
    transform = lambda s: GAMMA / s**2 * (1 - cosh(y * sqrt(s)) / cosh(sqrt(s)))
    return invertlaplace(transform, t, method="talbot", degree=60)


print("# u_t = 2 + u_yy, |y| <= 1, u(+-1) = 0, u(y, 0) = 0; written by poiseuille-series.py, mpmath 1.3.0, 60 digits")
print("y,t,u")
for t_text in ["1e-8", "1e-5", "1e-3", "0.02", "0.0277", "0.0278", "0.1", "0.5", "1.0", "3.0", "10.0"]:
    for y_text in ["0.0", "0.3", "-0.7", "0.99", "0.9999999"]:
        y, t = mpf(float(y_text)), mpf(float(t_text))
        u = series(y, t)
        check = laplace(y, t)
        assert abs(u - check) <= mpf(10) ** -22 * abs(u), (y_text, t_text, u, check)
        print(f"{y_text},{t_text},{nstr(u, 25, strip_zeros=False)}")

/* The classical Runge-Kutta method on two problems, as `verify order --program` runs it:
 *
 *     cc -O2 -o rk4 rk4.c -lm
 *     verify order --problem van-der-pol --program ./rk4 --expect 4
 *
 * -DWRONG evaluates the third stage from the first instead of the second, as after a slip of the pen.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double mu = 1.0, lambda = 1.0;
static int logistic, n;

static void f(const double *v, double *dv)
{
    if (logistic) {
        dv[0] = lambda * v[0] * (1.0 - v[0]);
    } else {
        dv[0] = v[1];
        dv[1] = mu * (1.0 - v[0] * v[0]) * v[1] - v[0];
    }
}

static void stage(const double *v, double h, const double *k, double *out)
{
    double moved[2];
    for (int i = 0; i < n; i++)
        moved[i] = v[i] + h * k[i];
    f(moved, out);
}

static void step(double *v, double h)
{
    double k1[2], k2[2], k3[2], k4[2];
    f(v, k1);
    stage(v, 0.5 * h, k1, k2);
#ifdef WRONG
    stage(v, 0.5 * h, k1, k3);
#else
    stage(v, 0.5 * h, k2, k3);
#endif
    stage(v, h, k3, k4);
    for (int i = 0; i < n; i++)
        v[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
}

int main(int argc, char **argv)
{
    double h = 0.0, t_end = 0.0, v[2] = {2.0, 0.0};
    const char *problem = "";
    for (int i = 1; i + 1 < argc; i += 2) {
        if (!strcmp(argv[i], "--problem"))
            problem = argv[i + 1];
        else if (!strcmp(argv[i], "--h"))
            h = atof(argv[i + 1]);
        else if (!strcmp(argv[i], "--t-end"))
            t_end = atof(argv[i + 1]);
        else if (!strcmp(argv[i], "--set"))
            sscanf(argv[i + 1], "mu=%lf", &mu) || sscanf(argv[i + 1], "lambda=%lf", &lambda);
    }
    logistic = !strcmp(problem, "logistic");
    n = logistic ? 1 : 2;
    if (!logistic && strcmp(problem, "van-der-pol")) {
        fprintf(stderr, "rk4 knows logistic and van-der-pol, not %s\n", problem);
        return 2;
    }
    if (logistic)
        v[0] = 0.1;
    long steps = (long)ceil(t_end / h - 1e-9);
    puts(logistic ? "t,v" : "t,x,y");
    for (long k = 0; k <= steps; k++) {
        /* The last step is cut short where h does not divide the time. */
        double t = k < steps ? k * h : t_end, next = k + 1 < steps ? (k + 1) * h : t_end;
        printf("%.17g,%.17g", t, v[0]);
        if (n == 2)
            printf(",%.17g", v[1]);
        putchar('\n');
        step(v, next - t);
    }
    return 0;
}

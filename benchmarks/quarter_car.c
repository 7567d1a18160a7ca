/* The quarter car of AP57 section 8 with blow-off and lift-off (contact by force), hard-coded: linear
   acceleration with Newton's iteration to the equilibrium at the end of each fixed step (H83 15.12, 15.13).
   What a step of the general integrator is measured against. */

#include <math.h>

static const double M = 294.1995, m = 29.41995, C1 = 14709.975, C2 = 147099.75, K2 = 980.665;
static const double REBOUND = 1961.33, BUMP = 490.3325, OPEN_UP = 0.3, OPEN_DOWN = -0.6;
static const double WEIGHT = (294.1995 + 29.41995) * 9.80665;
static const double RATE = 125.66370614359172, HEIGHT = 0.05, PASSED = 0.05;

/* Steps of length h from rest; state holds both displacements at the end. Returns the iterations. */
long run(long steps, double h, double *state)
{
    double x1 = 0, x2 = 0, v1 = 0, v2 = 0, a1 = 0, a2 = 0;
    long iterations = 0;
    for (long k = 1; k <= steps; k++) {
        const double t = k * h;
        double xi = 0, dxi = 0;
        if (t < PASSED) {
            xi = 0.5 * HEIGHT * (1 - cos(RATE * t));
            dxi = 0.5 * HEIGHT * RATE * sin(RATE * t);
        }
        const double pv1 = v1 + h / 2 * a1, pv2 = v2 + h / 2 * a2;
        const double px1 = x1 + h * v1 + h * h / 3 * a1, px2 = x2 + h * v2 + h * h / 3 * a2;
        for (int i = 0; i < 25; i++) {
            v1 = pv1 + h / 2 * a1, v2 = pv2 + h / 2 * a2;
            x1 = px1 + h * h / 6 * a1, x2 = px2 + h * h / 6 * a2;
            iterations++;
            const double y = x1 - x2, w = v1 - v2;
            double damper, slope;
            if (w > OPEN_UP)
                slope = REBOUND / 5, damper = REBOUND * OPEN_UP + slope * (w - OPEN_UP);
            else if (w >= 0)
                slope = REBOUND, damper = slope * w;
            else if (w >= OPEN_DOWN)
                slope = BUMP, damper = slope * w;
            else
                slope = BUMP / 5, damper = BUMP * OPEN_DOWN + slope * (w - OPEN_DOWN);
            double tyre = C2 * (x2 - xi) + K2 * (v2 - dxi);
            double on_tyre = h / 2 * K2 + h * h / 6 * C2;
            if (tyre > WEIGHT)
                tyre = WEIGHT, on_tyre = 0;
            const double strut = C1 * y + damper, on_strut = h / 2 * slope + h * h / 6 * C1;
            const double r1 = -strut - M * a1, r2 = strut - tyre - m * a2;
            const double m11 = M + on_strut, m22 = m + on_strut + on_tyre;
            const double determinant = m11 * m22 - on_strut * on_strut;
            const double d1 = (m22 * r1 + on_strut * r2) / determinant;
            const double d2 = (on_strut * r1 + m11 * r2) / determinant;
            a1 += d1, a2 += d2;
            if (fabs(d1) + fabs(d2) <= 1e-12 * (fabs(a1) + fabs(a2)))
                break;
        }
        v1 = pv1 + h / 2 * a1, v2 = pv2 + h / 2 * a2;
        x1 = px1 + h * h / 6 * a1, x2 = px2 + h * h / 6 * a2;
    }
    state[0] = x1, state[1] = x2;
    return iterations;
}

/* The floor: the figures of a PID's loop around K/(s (s + a)) in plain C, one loop after the other.
 *
 * It is given what zoh's arithmetics must find out: that the plant has order 2 and no delay, that
 * the loop can be designed and is stable, that its gain is 1 at the crossover asked for alone, that
 * its phase crosses -180 deg upwards of that once, that |S|, |T| and the balanced sensitivity have
 * one peak each, and that a response whose last 64 samples lie within 1 % of each other's mean has
 * shown all there is. It proves none of it, and is right of the nominal loops alone.
 *
 * Each figure is found to its last digits: roots by Newton's method, the crest between two samples
 * on the plant's own response.
 */
#include <math.h>

enum { GM, PHASE_CROSSOVER, PM, CROSSOVER, DELAY, MODULUS, MS, MT, DISK, BANDWIDTH, MARGINS };
enum { OVERSHOOT, RISE, SETTLING, PEAK, PEAK_TIME, ERROR, EFFORT, OVER_ALL, TIME_ALL, STEPS };
enum { GRID = 16, QUIET = 64, MOST = 100000 };

/* a(jv) of degree 4, ascending powers, and |a(jv)|^2 by powers of q = v^2 */
static void on_axis(const double *a, double v, double *re, double *im)
{
    double q = v * v;
    *re = a[0] - q * (a[2] - q * a[4]);
    *im = v * (a[1] - q * a[3]);
}

static void squared(const double *a, double *out)
{
    out[0] = a[0] * a[0];
    out[1] = a[1] * a[1] - 2.0 * a[0] * a[2];
    out[2] = a[2] * a[2] - 2.0 * a[1] * a[3] + 2.0 * a[0] * a[4];
    out[3] = a[3] * a[3] - 2.0 * a[2] * a[4];
    out[4] = a[4] * a[4];
}

static double at(const double *a, double q)
{
    return (((a[4] * q + a[3]) * q + a[2]) * q + a[1]) * q + a[0];
}

static double slope(const double *a, double q)
{
    return ((4.0 * a[4] * q + 3.0 * a[3]) * q + 2.0 * a[2]) * q + a[1];
}

static double bend(const double *a, double q)
{
    return (12.0 * a[4] * q + 6.0 * a[3]) * q + 2.0 * a[2];
}

/* the root next to q, from a side from which Newton's method arrives, or by halving */
static double root(const double *a, double low, double high)
{
    double q = sqrt(low * high);
    int rising = at(a, low) < 0.0;
    for (int i = 0; i < 100; i++) {
        double f = at(a, q), new = q - f / slope(a, q);
        if ((f < 0.0) == rising)
            low = q;
        else
            high = q;
        if (!(low < new && new < high))
            new = sqrt(low * high);
        if (fabs(new - q) <= 1e-13 * q)
            return new;
        q = new;
    }
    return q;
}

/* the first pair of neighbours on the grid between which a changes its sign */
static double first_root(const double *a, const double *grid)
{
    for (int i = 0; i + 1 < GRID; i++)
        if ((at(a, grid[i]) < 0.0) != (at(a, grid[i + 1]) < 0.0))
            return root(a, grid[i], grid[i + 1]);
    return NAN;
}

/* the least of sqrt(a/b), at one of the axis' ends, or where Newton's method on the slope ends */
static double least(const double *a, const double *b, const double *grid)
{
    double value[GRID];
    int best = 1;
    for (int i = 0; i < GRID; i++)
        value[i] = at(a, grid[i]) / at(b, grid[i]);
    for (int i = 1; i + 1 < GRID; i++)
        if (value[i] < value[best])
            best = i;
    double q = grid[best], low = grid[best - 1], high = grid[best + 1];
    for (int i = 0; i < 60; i++) {
        double fa = at(a, q), fb = at(b, q);
        double g = slope(a, q) * fb - fa * slope(b, q), dg = bend(a, q) * fb - fa * bend(b, q);
        double new = q - g / dg;
        if (g < 0.0)
            low = q;
        else
            high = q;
        if (!(low < new && new < high))
            new = sqrt(low * high);
        if (fabs(new - q) <= 1e-8 * q) { /* the value is flat there */
            q = new;
            break;
        }
        q = new;
    }
    return sqrt(fmin(at(a, q) / at(b, q), fmin(a[0] / b[0], a[4] / b[4])));
}

static void margins(const double *num, const double *den, double x, double dt, const double *grid,
                    double *out)
{
    double nn[5], dd[5], ss[5], bb[5], some[5], a, b, c, d;
    squared(num, nn);
    squared(den, dd);
    for (int i = 0; i < 5; i++)
        some[i] = num[i] + den[i];
    squared(some, ss);
    for (int i = 0; i < 5; i++)
        some[i] = den[i] - num[i];
    squared(some, bb);
    on_axis(num, 1.0, &a, &b);
    on_axis(den, 1.0, &c, &d);
    double pm = atan2(-(b * c - a * d), -(a * c + b * d));
    out[PM] = pm * (180.0 / M_PI);
    out[CROSSOVER] = 2.0 / dt * atan(x);
    out[DELAY] = pm / out[CROSSOVER];
    /* Im L = 0: v times a cubic in q, of which the crossing above the crossover is looked for */
    double en[3] = {num[0], -num[2], num[4]}, on[2] = {num[1], -num[3]};
    double ed[3] = {den[0], -den[2], den[4]}, od[2] = {den[1], -den[3]};
    for (int i = 0; i < 5; i++)
        some[i] = 0.0;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 2; j++)
            some[i + j] += on[j] * ed[i] - en[i] * od[j];
    out[GM] = -den[4] / num[4];
    out[PHASE_CROSSOVER] = M_PI / dt;
    for (int i = 0; i + 1 < GRID; i++) {
        if ((at(some, grid[i]) < 0.0) == (at(some, grid[i + 1]) < 0.0))
            continue;
        double q = root(some, grid[i], grid[i + 1]), v = sqrt(q);
        on_axis(num, v, &a, &b);
        on_axis(den, v, &c, &d);
        double factor = -(c * c + d * d) / (a * c + b * d);
        if (factor > 0.0 && (!(out[GM] > 0.0) || fabs(log(factor)) < fabs(log(out[GM])))) {
            out[GM] = factor;
            out[PHASE_CROSSOVER] = 2.0 / dt * atan(x * v);
        }
    }
    out[MODULUS] = least(ss, dd, grid);
    out[MS] = 1.0 / out[MODULUS];
    out[MT] = 1.0 / least(ss, nn, grid);
    out[DISK] = 2.0 * least(ss, bb, grid);
    double drop = pow(10.0, -0.3);
    for (int i = 0; i < 5; i++)
        some[i] = nn[i] - drop * nn[0] / ss[0] * ss[i];
    out[BANDWIDTH] = 2.0 / dt * atan(x * sqrt(first_root(some, grid)));
}

/* y and its slope by the state, t s after a sample at which it was y0, v0 and since when u holds */
static double after(double gain, double a, double y0, double v0, double u, double t, double *v)
{
    double fall = exp(-a * t), rest = gain * u / a;
    *v = rest + (v0 - rest) * fall;
    return y0 + rest * t + (v0 - rest) * (1.0 - fall) / a;
}

static void step(double gain, double a, double dt, double fast, double kp, double share, double rate,
                 double *out)
{
    double rest = (1.0 - fast) / a, far = (dt - rest) / a;
    double y = 0.0, v = 0.0, sum = 0.0, before = 0.0, top = 0.0, high = 0.0, when = 0.0;
    double most = 0.0, lowest = 0.0;
    int k, k_top = 0, k_10 = -1, k_90 = -1, out_of = -1, quiet = 0;
    for (k = 0; k < MOST && quiet < QUIET; k++) {
        double e = 1.0 - y;
        double u = kp * e + share * (2.0 * sum + e) + rate * (e - before) / 2.0;
        sum += e;
        before = e;
        most = fmax(most, u);
        lowest = fmin(lowest, u);
        if (y > top) {
            if (k_10 < 0 && y >= 0.1)
                k_10 = k;
            if (k_90 < 0 && y >= 0.9)
                k_90 = k;
            top = y;
            k_top = k;
        }
        if (fabs(e) > 0.02)
            out_of = k;
        quiet = fabs(e) < 0.01 ? quiet + 1 : 0;
        double next = y + rest * v + gain * far * u, slower = fast * v + gain * rest * u;
        if (v > 0.0 && slower < 0.0 && fmax(y, next) > high - 0.1) {
            double t = dt * v / (v - slower), w, crest;
            for (int i = 0; i < 20; i++) {
                crest = after(gain, a, y, v, u, t, &w);
                double by = w / (gain * u - a * w);
                t -= by;
                if (fabs(by) <= 1e-12 * dt)
                    break;
            }
            crest = after(gain, a, y, v, u, t, &w);
            if (crest > high) {
                high = crest;
                when = k * dt + t;
            }
        }
        y = next;
        v = slower;
    }
    if (top > high) {
        high = top;
        when = k_top * dt;
    }
    out[OVERSHOOT] = top > 1.0 ? 100.0 * (top - 1.0) : 0.0;
    out[RISE] = (k_90 - k_10) * dt;
    out[SETTLING] = (out_of + 1) * dt;
    out[PEAK] = fmax(top, 1.0);
    out[PEAK_TIME] = top > 1.0 ? k_top * dt : NAN;
    out[ERROR] = 0.0;
    out[EFFORT] = fmax(most, -lowest);
    out[OVER_ALL] = high > 1.0 ? 100.0 * (high - 1.0) : 0.0;
    out[TIME_ALL] = high > 1.0 ? when : NAN;
}

/* columns in, a row of MARGINS + STEPS figures a loop out */
void floor_of(long loops, const double *dts, const double *gains, const double *as,
              const double *wcs, const double *pms, const double *kis, double *figures)
{
    double grid[GRID];
    for (int i = 0; i < GRID; i++)
        grid[i] = pow(10.0, -2.0 + 6.0 * i / (GRID - 1));
    for (long i = 0; i < loops; i++) {
        double dt = dts[i], gain = gains[i], a = as[i], x = tan(wcs[i] * dt / 2.0);
        double fast = exp(-a * dt), lost = -expm1(-a * dt);
        double b1 = gain * (a * dt - lost) / (a * a), b2 = gain * (lost - a * dt * fast) / (a * a);
        /* in p = (z - 1)/(z + 1); then the crossover to 1 */
        double n0 = b1 + b2, n1 = b1 - b2, d1 = 2.0 * lost, d2 = 2.0 * (1.0 + fast);
        double re = n0 + n1 * x * x, im = (n1 - n0) * x; /* (n0 + n1 p)(1 - p) at jx */
        double over = hypot(re, im) / (x * hypot(d1, d2 * x));
        double turn = atan2(im, re) - M_PI / 2.0 - atan2(d2 * x, d1);
        double theta = remainder((pms[i] - 180.0) * (M_PI / 180.0) - turn, 2.0 * M_PI);
        double share = kis[i] * dt / 2.0;
        double swing = sin(theta) / over + share / x;
        double kp = cos(theta) / over - x * swing, rate = swing * (1.0 + x * x) / x;
        double c0 = share, c1 = kp + share, c2 = kp + rate;
        double m1 = n1 - n0, m2 = -n1, x2 = x * x, x3 = x2 * x, x4 = x2 * x2;
        double num[5] = {n0 * c0, (n0 * c1 + m1 * c0) * x, (n0 * c2 + m1 * c1 + m2 * c0) * x2,
                         (m1 * c2 + m2 * c1) * x3, m2 * c2 * x4};
        double den[5] = {0.0, 0.0, d1 * x2, (d1 + d2) * x3, d2 * x4};
        double *row = figures + i * (MARGINS + STEPS);
        margins(num, den, x, dt, grid, row);
        step(gain, a, dt, fast, kp, share, rate, row + MARGINS);
    }
}

"""Write convert.json: sampling by every method but the zero-order hold, in mpmath.

python tests/oracles/convert_make.py. Another road than zoh's: matrix exponentials of companion
forms, fractions for the difference rules, no line of zoh. For a delay of m dt - e:

    impulse   g_j = dt c exp(A (j dt + e)) b
    ramp      the state of [A b 0; 0 0 1; 0 0 0] driven by u = t; its second differences / dt
    matched   characteristic polynomials of exp(A dt), A the companion of num and of den
    the rest  s = (a/dt)(z - 1)/(theta z + 1 - theta), expanded in exact fractions

The working precision doubles until two of them agree, so no digit is taken on trust.
"""

import json
import random
import sys
from fractions import Fraction
from pathlib import Path

import truth_hold as hold  # beside this script, whose folder Python looks in first
from mpmath import mp, mpf

HERE = Path(__file__).resolve().parent
DIGITS = 30  # written down; agreed to 48
DTS = (1.0, 0.1, 1e-3, 1e-6)
PREWARP = 0.7  # of the Nyquist frequency
THETA = {"forward": Fraction(0), "tustin": Fraction(1, 2), "backward": Fraction(1)}
THETA["prewarp"] = THETA["tustin"]


def impulse(num, den, gain, dt, theta):
    """Return (num, den, delay) in z at the present working precision."""
    matrix, col, row, _ = hold.companion(num, den)
    n = matrix.rows
    m, eps = hold.whole_and_rest(theta, dt)
    phi = mp.expm(matrix * mpf(dt), method="taylor")
    x = mp.expm(matrix * eps, method="taylor") * col if eps else col
    pulses = []
    for _ in range(n + 1):
        pulses.append(mpf(gain) * mpf(dt) * sum(row[i] * x[i] for i in range(n)))
        x = phi * x
    bottom = hold.characteristic(phi)
    return products(bottom, pulses), bottom, m


def ramp(num, den, gain, dt, theta):
    matrix, col, row, direct = hold.companion(num, den)
    n = matrix.rows
    m, eps = hold.whole_and_rest(theta, dt)
    big = mp.zeros(n + 2, n + 2)
    for i in range(n):
        for j in range(n):
            big[i, j] = matrix[i, j]
        big[i, n] = col[i]
    big[n, n + 1] = mpf(1)
    one = mp.expm(big * mpf(dt), method="taylor")
    x = mp.zeros(n + 2, 1)
    x[n + 1] = mpf(1)
    if eps:
        x = mp.expm(big * eps, method="taylor") * x
    responses = [mpf(0), mpf(0)]
    for _ in range(n + 2):
        responses.append(sum(row[i] * x[i] for i in range(n)) + direct * x[n])
        x = one * x
    bends = [
        mpf(gain) * (c - 2 * b + a) / mpf(dt)
        for a, b, c in zip(responses, responses[1:], responses[2:], strict=False)
    ]
    bottom = hold.characteristic(one[:n, :n])
    if not eps:
        return products(bottom, bends[1:]), bottom, m
    bottom = [*bottom, mpf(0)]
    return products(bottom, bends), bottom, m - 1


def matched(num, den, gain, dt, theta):
    m, _ = hold.whole_and_rest(theta, dt)
    top, bottom = through_exp(num, dt), through_exp(den, dt)
    missing = max(len(den) - len(num) - 1, 0)
    for _ in range(missing):
        top = hold.convolve(top, [mpf(1), mpf(1)])
    zeros, poles = origin(num), origin(den)
    lowest = mpf(gain) * mpf(num[-1 - zeros]) / mpf(den[-1 - poles])
    # both are divided by their powers of z - 1 and taken at z = 1: a derivative, over n!
    ratio = derivative_at_one(bottom, poles) / derivative_at_one(top, zeros)
    k = lowest * mpf(dt) ** (poles - zeros) * ratio
    top = [mpf(0)] * (len(bottom) - len(top)) + [k * c for c in top]
    return top, bottom, m


def products(bottom, values):
    return [sum(bottom[i] * values[j - i] for i in range(j + 1)) for j in range(len(bottom))]


def through_exp(a, dt):
    if len(a) == 1:
        return [mpf(1)]
    matrix = hold.companion([1.0], a)[0]
    return hold.characteristic(mp.expm(matrix * mpf(dt), method="taylor"))


def origin(a):
    return next(i for i, c in enumerate(reversed(a)) if c)


def derivative_at_one(a, order):
    n = len(a) - 1
    return sum(c * mp.binomial(n - i, order) for i, c in enumerate(a) if n - i >= order)


LIMITS = {"impulse": impulse, "foh": ramp, "matched": matched}


def in_limits(method, num, den, gain, dt, theta):
    """Return num_z, den_z, num_w, den_w, delay, each coefficient agreed upon to 48 digits."""
    work, last = 200, None
    while work < 20000:
        with mp.workdps(work):
            top, bottom, m = LIMITS[method](num, den, gain, dt, theta)
            scale = int(mp.log10(max(mpf(dt), 1 / mpf(dt)))) * len(den)
            parts = [hold.clean(top, work), hold.clean(bottom, work)]
            parts += [hold.rescaled(hold.in_w(p, dt), dt, work - scale) for p in parts]
            same = last and all(hold.agree(a, b, 48) for a, b in zip(last, parts, strict=True))
            if same:
                return *parts, m
            last = parts
        work *= 2
    raise ArithmeticError("no agreement")


def by_rule(method, num, den, gain, dt, theta):
    """Return the same for a difference rule; fractions, but for the factor of prewarping."""
    share, step = THETA[method], Fraction(dt)
    a = Fraction(1)
    if method == "prewarp":
        with mp.workdps(120):
            x = mpf(float(PREWARP * mp.pi / mpf(dt))) * mpf(dt) / 2
            a = Fraction(int(mp.floor(x * mp.cot(x) * mpf(2) ** 300)), 2**300)
    n = len(den) - 1
    forms = []
    for c in ([Fraction(gain) * Fraction(x) for x in num], [Fraction(x) for x in den]):
        c = [Fraction(0)] * (n + 1 - len(c)) + c
        total = [Fraction(0)] * (n + 1)
        for i, x in enumerate(c):
            term = [x * a ** (n - i)]
            for _ in range(n - i):
                term = hold.convolve(term, [Fraction(1), Fraction(-1)])
            for _ in range(i):
                term = hold.convolve(term, [share * step, (1 - share) * step])
            total = [p + q for p, q in zip(total, term, strict=True)]
        forms.append(total)
    lead = forms[1][0]
    forms = [[c / lead for c in form] for form in forms]
    forms += [exactly_in_w(form, step) for form in forms]
    with mp.workdps(60):
        numbers = [[mpf(c.numerator) / mpf(c.denominator) for c in form] for form in forms]
    return *numbers, round(theta / dt)


def exactly_in_w(a, step):
    n = len(a) - 1
    total = [Fraction(0)] * (n + 1)
    for i, c in enumerate(a):
        term = [c]
        for k in range(n):
            term = hold.convolve(term, [step / 2 * (1 if k < n - i else -1), Fraction(1)])
        total = [x + y for x, y in zip(total, term, strict=True)]
    return total


def plants():
    rng = random.Random(21)
    poles = [-rng.uniform(0.2, 3) for _ in range(8)]
    poles += [(-rng.uniform(-0.1, 1), rng.uniform(0.3, 3)) for _ in range(6)]
    zeros = [-rng.uniform(0.2, 3) for _ in range(5)] + [(rng.uniform(-1, 1), 1.3)]
    order_20 = "order 20", hold.polynomial(zeros), hold.polynomial(poles), 1.0
    hidden = "differentiator", [1.0, 0.5, 0.0, 0.0], hold.polynomial([-1.0, -2.0, -2.0]), 1.0
    return [*hold.plants(), hidden, order_20]


def wanted():
    """Yield (method, plant, dt, dead time in dt)."""
    for plant in plants():
        name, num, den, _ = plant
        for dt in DTS:
            if hold.FASTEST.get(name, 2.3) * dt > hold.LIMIT or (name == "order 20" and dt == 0.1):
                continue
            for share in (0.0, 0.3) + ((2.7, 3.0) if name == "arm" else ()):
                yield "foh", plant, dt, share
                if len(num) < len(den):
                    yield "impulse", plant, dt, share
            # backward would send the unstable plant's pole at 1 rad/s to infinity
            rules = [r for r in THETA if (r, name, dt) != ("backward", "unstable", 1.0)]
            for share in (0.0, 2.0) if name in ("arm", "feedthrough") else (0.0,):
                yield "matched", plant, dt, share
                if dt != 0.1:
                    for method in rules:
                        yield method, plant, dt, share


def one_case(method, plant, dt, share):
    name, num, den, gain = plant
    make = by_rule if method in THETA else in_limits
    *parts, m = make(method, num, den, gain, dt, share * dt)
    case = {"method": method, "plant": name, "num": num, "den": den, "sensor": gain, "dt": dt}
    case |= {"dead_time": share * dt, "delay": m}
    if method == "prewarp":
        case["prewarp"] = float(PREWARP * mp.pi / mpf(dt))
    for key, part in zip(("num_z", "den_z", "num_w", "den_w"), parts, strict=True):
        case[key] = [mp.nstr(c, DIGITS, min_fixed=0, max_fixed=0) for c in part]
    return case


def main():
    cases = []
    for method, plant, dt, share in wanted():
        cases.append(one_case(method, plant, dt, share))
        sys.stderr.write(f"\r{len(cases)} {method} {plant[0]} {dt:g}          ")
    lines = ",\n".join(json.dumps(case) for case in cases)
    (HERE / "convert.json").write_text(f"[\n{lines}\n]\n")
    sys.stderr.write(f"\nconvert.json: {len(cases)} cases\n")


if __name__ == "__main__":
    main()

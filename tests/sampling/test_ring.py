"""The ring of the step response: its moduli by hand, its exponentials in fifty digits."""

from decimal import Decimal
from math import log, log10

import pytest
from mpmath import mp, mpf

from zoh.errors import SpecError
from zoh.lti.digits import exact, precision
from zoh.sampling.ring import StepResponse, _bound, _dot, _log10, _trailing_zeros, digits_needed

D = Decimal


def response(num, den, gain=1.0, dt=1.0):
    return StepResponse.of(exact(num), exact(den), D(gain), D(dt))


def same(found, truth):
    """Fifty digits of eighty."""
    with mp.workdps(90):
        return all(
            abs(mpf(str(f)) - t) <= abs(t) * mpf(10) ** -50
            for f, t in zip(found, truth, strict=True)
        )


def test_logarithms_of_decimals_beyond_the_floats():
    assert _log10(D("1e-900")) == -900
    assert _log10(D("-2e500")) == pytest.approx(500 + log10(2), rel=1e-15)
    assert _log10(D("0.03")) == pytest.approx(log10(0.03), rel=1e-15)


def test_fujiwaras_bound():
    # 2 max |a_i|^(1/i): of s^2 + 3 s + 100 it is 2 10, of s^2 + 30 s + 100 it is 2 30
    assert _bound(exact([1, 3, 100])) == pytest.approx(log10(20), rel=1e-15)
    assert _bound(exact([1, 30, 100])) == pytest.approx(log10(60), rel=1e-15)
    assert _bound(exact([1000, 0, 100])) == pytest.approx(log10(20), rel=1e-15)  # the first is 1
    assert _bound(exact([1, 0, 0])) == pytest.approx(log10(2) - 800, rel=1e-15)


NEEDED = [
    # 60 + 2 n, the rest nothing: 1/(s + 1) has e^2 for its bound: 2/ln 10 = 0.87
    ([1], [1, 1], 1.0, 60 + 2 + 2 / log(10)),
    # 1/(s + 1) at 1e-3: slow 3, twice; a single number on top; fast 2e-3/ln 10
    ([1], [1, 1], 1e-3, 60 + 2 * 3 + 2 + 2e-3 / log(10)),
    # 100 (s + 1e-5)/(4 s^2 + 4 s + 1): over 4; the numbers on top are 5 apart; the bound is 2 1
    ([100, 1e-3], [4, 4, 1], 1.0, 60 + 2 * log10(4) + 5 + 4 + 2 * 2 / log(10)),
    # at 0.01 s the top's numbers are 7 apart, and 1/4 is 1e-4/4; fast 2 2e-2/ln 10
    ([100, 1e-3], [4, 4, 1], 0.01, 60 + 2 * (4 + log10(4)) + 7 + 4 + 0.04 / log(10)),
    # no more than 1e3 of the bound is counted, and no more than 800
    ([1], [1, 1e9], 1.0, 60 + 2 + 1000 / log(10)),
    ([1], [1, 1e9, 1e18], 1.0, 60 + 4 + 800),
    # an integrator's 0 is no slow pole
    ([1], [1, 1, 0], 1.0, 60 + 4 + 2 * 2 / log(10)),
    ([3], [2], 1.0, 60),
]


@pytest.mark.parametrize(("num", "den", "dt", "digits"), NEEDED)
def test_the_digits_that_are_needed(num, den, dt, digits):
    assert digits_needed(exact(num), exact(den), dt) == int(digits)


def test_a_response_in_its_ring():
    # 3 (s + 5)/(2 s^2 + 6 s + 4) at 2: 1.5 (s + 5)/(s^2 + 3 s + 2), in sigma = 2 s
    # sigma^2 + 6 sigma + 8; the top 0, 3, 30; y(0+) = 0, y' = 3, y'' = 30 - 6 3
    got = response([1, 5], [2, 6, 4], gain=3.0, dt=2.0)
    assert got.modulus == (0, 8, 6)
    assert got.markov == (0, 3, 12)
    assert got.sums == (2, -6, 20)  # of -2 and -4
    assert (got.order, got.integrators, got.zeros_at_origin) == (2, 0, 0)
    # (s^2 + 4 s)/(s^2 + s): y(0+) = 1, y' = 4 - 1, y'' = 0 - 3
    got = response([1, 4, 0], [1, 1, 0])
    assert (got.modulus, got.markov) == ((0, 0, 1), (1, 3, -3))
    assert got.sums == (1, -1, 1)  # the pole at -1 alone
    assert (got.order, got.integrators, got.zeros_at_origin) == (2, 1, 1)
    assert response([1], [1, 0, 0]).integrators == 2


def test_products_in_the_ring():
    # modulo sigma^3 + 6 sigma^2 + 8 sigma
    ring = response([1, 5], [2, 6, 4], gain=3.0, dt=2.0)
    assert ring.times_sigma([D(1), D(2), D(3)]) == [0, 1 - 24, 2 - 18]
    # (1 + 2 x + 3 x^2)(4 + 5 x) = 4 + 13 x + 22 x^2 + 15 x^3, less 15 (8 x + 6 x^2)
    assert ring._product([D(1), D(2), D(3)], [D(4), D(5), D(0)]) == [4, 13 - 120, 22 - 90]
    assert _dot([D(1), D(2)], [D(3), D(4)]) == 11
    assert _trailing_zeros(exact([1, 0, 2, 0, 0])) == 2
    assert _trailing_zeros(exact([1, 2])) == 0


@pytest.mark.parametrize("t", ["0.001", "0.3", "1", "7"])
def test_exponentials_of_two_modes(t):
    # exp(sigma t) modulo sigma (sigma + 2)(sigma + 4) takes the values 1, e^-2t and e^-4t there
    with precision(80):
        a, b, c = response([1, 5], [2, 6, 4], dt=2.0).exponential(D(t))
        values = a, a - 2 * b + 4 * c, a - 4 * b + 16 * c
    with mp.workdps(90):
        assert same(values, [mpf(1), mp.exp(-2 * mpf(t)), mp.exp(-4 * mpf(t))])


def test_exponentials_of_integrators_are_polynomials():
    with precision(80):
        assert response([1], [1, 0, 0]).exponential(D("0.5")) == [1, D("0.5"), D("0.125")]


@pytest.mark.parametrize("lead", ["0", "0.25"])
def test_the_samples_of_a_response(lead):
    # 1/((s + 1)(s + 2)) at 1: y = 1/2 - e^-t + e^-2t/2; poles e^-1 and e^-2
    with precision(80):
        poles, values = response([1], [1, 3, 2]).sampled(D(lead))
    with mp.workdps(90):
        e, f = mp.exp(-1), mp.exp(-2)
        assert same(poles, [mpf(1), -(e + f), e * f])
        times = [mpf(lead) + j for j in range(3)]
        truth = [mpf(1) / 2 - mp.exp(-t) + mp.exp(-2 * t) / 2 for t in times]
        assert abs(mpf(str(values[0])) - truth[0]) < mpf(10) ** -70
        assert same(values[1:], truth[1:])


def test_the_moving_poles_alone():
    # 1/(s^2 (s + 1)) keeps e^-1; y = t^2/2 - t + 1 - e^-t
    with precision(80):
        poles, values = response([1], [1, 1, 0, 0]).sampled(D(0))
    with mp.workdps(90):
        assert same(poles, [mpf(1), -mp.exp(-1)])
        truth = [mpf(t) ** 2 / 2 - t + 1 - mp.exp(-t) for t in range(4)]
        assert abs(mpf(str(values[0]))) < mpf(10) ** -70
        assert same(values[1:], truth[1:])


def test_a_mode_that_no_exponent_holds():
    with precision(80), pytest.raises(SpecError) as refused:
        response([1], [1, 1e19]).exponential(D(1))
    assert str(refused.value) == (
        "dt must not be as long against the plant's fastest mode, got '1e19 times its time "
        "constant': sample faster, or leave the fast mode out of the model"
    )
    # 2 2^55 times 8 is 2^59 and takes 59 halvings and one for what is rounded up, 2^57 62
    with precision(80):
        assert response([1], [1, 2.0**55]).exponential(D(1))
        assert response([1], [1, 2.0**56]).exponential(D(1))
    with precision(80), pytest.raises(SpecError):
        response([1], [1, 2.0**57]).exponential(D(1))

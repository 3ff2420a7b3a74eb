"""Formulas: read exactly, refused with a place and a way out, never guessed."""

import time
from fractions import Fraction as F

import pytest
from hypothesis import given
from hypothesis import strategies as st

from zoh.errors import SpecError
from zoh.lti.hidden import hidden_modes
from zoh.lti.parse import formula, quotient
from zoh.lti.systems import Plant

# Worked with a pencil; every coefficient is the exact decimal that is written.
BY_HAND = [
    # text                              num                    den                       delay
    ("2.3/(s^2 + 0.7809 s)",            [F("2.3")],            [1, F("0.7809"), 0],      0),
    ("2.3*12/180/(s*(s+0.7809))",       [F("2.3") / 15],       [1, F("0.7809"), 0],      0),
    ("1e3 / (s**2 + 2*0.1*5 s + 25)",   [1000],                [1, 1, 25],               0),
    ("exp(-0.05 s) * 2/(10 s + 1)",     [2],                   [10, 1],                  F(1, 20)),
    ("2 exp(-s/20)/(10 s + 1)",         [2],                   [10, 1],                  F(1, 20)),
    ("exp(-s)^2 exp(-(1/2)*s)/s",       [1],                   [1, 0],                   F(5, 2)),
    ("exp(-s)/s + exp(-s)",             [1, 1],                [1, 0],                   1),
    ("-3(s+1)(s+2)/s^3",                [-3, -9, -6],          [1, 0, 0, 0],             0),
    ("1/(1+s/10)",                      [1],                   [F(1, 10), 1],            0),
    ("1/(1 + 1/s)",                     [1, 0],                [1, 1],                   0),
    ("1/(1/(s+2))",                     [1, 2],                [1],                      0),
    ("(1/s)/(1/s^2)",                   [1, 0, 0],             [1, 0],                   0),
    ("(s+1)^3",                         [1, 3, 3, 1],          [1],                      0),
    ("(2/(s+1))^-2",                    [1, 2, 1],             [4],                      0),
    ("s^-1 + s^(-2)",                   [1, 1],                [1, 0, 0],                0),
    ("1/(2s) + 1/(2s)",                 [2],                   [2, 0],                   0),
    ("1/(s+1) + 1/(s+2)",               [2, 3],                [1, 3, 2],                0),
    ("(s-1)/((s-1)(s+2))",              [1, -1],               [1, 1, -2],               0),
    ("s/s",                             [1, 0],                [1, 0],                   0),
    ("-s^2",                            [-1, 0, 0],            [1],                      0),
    ("--+s",                            [1, 0],                [1],                      0),
    ("2^3 s",                           [8, 0],                [1],                      0),
    ("1/2*s",                           [F(1, 2), 0],          [1],                      0),
    ("1/2*3s",                          [F(3, 2), 0],          [1],                      0),
    ("6/2/3/s",                         [1],                   [1, 0],                   0),
    ("1 - 2 - 3",                       [-4],                  [1],                      0),
    (".5s + 5. + 1E+1",                 [F(1, 2), 15],         [1],                      0),
    ("2exp(-0 s)",                      [2],                   [1],                      0),
    ("\t1 /\n s ",                      [1],                   [1, 0],                   0),
]  # fmt: skip


@pytest.mark.parametrize(("text", "num", "den", "delay"), BY_HAND, ids=[c[0] for c in BY_HAND])
def test_matches_the_pencil(text, num, den, delay):
    got_num, got_den, got_delay = formula(text)
    # a fraction is the same at every scale, so compare num/num[0] as well as the ratio
    scale = F(den[0]) / got_den[0]
    assert [c * scale for c in got_num] == num
    assert [c * scale for c in got_den] == den
    assert got_delay == delay


def test_the_papers_plant_keeps_its_coefficients_as_they_are_written():
    assert formula("2.3/(s^2 + 0.7809 s)")[:2] == ((F(23, 10),), (F(1), F(7809, 10000), F(0)))


AMBIGUOUS = [
    ("1/2s", "(1/2)*s", "1/(2*s)"),
    ("1/2 (s+1)", "(1/2)*(s+1)", "1/(2*(s+1))"),
    ("1/(s+1)(s+2)", "(1/(s+1))*(s+2)", "1/((s+1)*(s+2))"),
    ("3 + 2*4/5s^2", "(2*4/5)*s^2", "2*4/(5*s^2)"),
    ("1/s exp(-s)", "(1/s)*exp(-s)", "1/(s*exp(-s))"),
]


@pytest.mark.parametrize(("text", "left", "right"), AMBIGUOUS)
def test_a_guess_is_refused_with_both_ways_to_write_it(text, left, right):
    with pytest.raises(SpecError) as e:
        formula(text)
    assert f"write {left} or {right}" in str(e.value)
    for way in (left, right.replace("*exp(-s))", ")")):  # dividing by exp() has no meaning
        formula(way)


REFUSED = [
    # text            what is named                       position
    ("",              "must not be empty",                None),
    ("   ",           "must not be empty",                None),
    ("1/(s+1",        "')' for every '('",                7),
    ("1/s)",          "'(' for every ')'",                4),
    ("()",            "number, s, exp or '('",            2),
    ("1/",            "it ends",                          3),
    ("*s",            "there is '*'",                     1),
    ("s+*2",          "there is '*'",                     3),
    ("1 2",           "operator before '2'",              3),
    ("s 2",           "operator before '2'",              3),
    ("(s)2",          "operator before '2'",              4),
    ("(1 2)",         "operator or ')' before '2'",       4),
    ("1.2.3",         "operator before '.3'",             4),
    ("2e-0.05",       "operator before '.05'",            5),
    ("K/(s+1)",       "not 'K'",                          1),
    ("1/S",           "small s",                          3),
    ("1/(z-1)",       "written in s",                     4),
    ("ss",            "not 'ss'",                         1),
    ("e^(-s)",        "exp(-T*s)",                        1),
    ("s+2j",          "zeros and poles",                  4),
    ("nan",           "not 'nan'",                        1),
    ("1/(s-s)",       "divide by zero",                   2),
    ("1/0",           "divide by zero",                   2),
    ("(s-s)^0",       "zero to a power",                  6),
    ("0^-1",          "zero to a power",                  2),
    ("s^51",          "exponents of 50 or less",          3),
    ("s^-99999999999999999999", "exponents of 50",        4),
    ("s^2.5",         "whole number",                     3),
    ("s^s",           "whole number",                     3),
    ("s^(1/2)",       "operator or ')' before '/'",       5),
    ("s^2^3",         "power to a power",                 4),
    ("s^50*s",        "order 50 or less (this is 51)",    5),
    ("(s+1)^26(s+2)^25", "order 50 or less",              9),
    ("1e999",         "64-bit float",                     1),
    ("1e-999999999999999999999", "64-bit float",          1),
    ("1e300*1e300",   "fit a 64-bit float",               None),
    ("1e-300*1e-300", "fit a 64-bit float",               None),
    ("((((1e300)^50)^50)^50)^50", "bits in a coefficient", 11),
    ("exp(s)",        "-T*s with T >= 0",                 1),
    ("exp(-s^2)",     "-T*s with T >= 0",                 1),
    ("exp(-1/s)",     "-T*s with T >= 0",                 1),
    ("exp(-s-1)",     "-T*s with T >= 0",                 1),
    ("exp(-1)",       "-T*s with T >= 0",                 1),
    ("exp(exp(-s))",  "-T*s with T >= 0",                 1),
    ("exp -s",        "'(' after exp",                    5),
    ("1/exp(-s)",     "divide by exp()",                  2),
    ("exp(-s)^-1",    "divide by exp()",                  8),
    ("1 + exp(-s)",   "different delays",                 3),
    ("exp(-s) - exp(-2s)", "different delays",            9),
    ("\u0663/s",      "\\u0663",                          1),
    ("s\u00b2",       "\\xb2",                            2),
    ("1\u22122/s",    "\\u2212",                          2),
    ("1/s\x00",       "\\x00",                            4),
    ("1/s;import os", "';'",                              4),
    ("__import__(os)", "not '__import__'",              1),
    ("(" * 1000 + "s", "40 nested parentheses",           41),
    ("s+" * 1000 + "s", "2000 characters",                None),
]  # fmt: skip


@pytest.mark.parametrize(("text", "named", "position"), REFUSED, ids=[c[0][:30] for c in REFUSED])
def test_refuses_with_a_place(text, named, position):
    with pytest.raises(SpecError) as e:
        formula(text, "plant.model")
    line = str(e.value)
    assert line.startswith("plant.model ")
    assert named in line
    assert "\n" not in line
    if position is not None:
        assert f"position {position}" in line


@pytest.mark.parametrize("value", [None, 3, 2.5, True, b"1/s", ["1/s"], {}])
def test_refuses_what_is_no_text(value):
    with pytest.raises(SpecError, match="must be a formula in quotes"):
        formula(value)


def test_a_hostile_text_costs_no_time():
    digits = "0." + "1234567890" * 4
    text = f"1/(s+{digits}1)^24 + 1/(s+{digits}2)^25 + 1/(s+{digits}3)"
    start = time.perf_counter()
    formula(text)
    assert time.perf_counter() - start < 5  # s: it takes 0.05; hundreds if digits grew unchecked


QUOTIENTS = [("12/180", 12 / 180), ("2*6/(90+90)", 12 / 180), (" 1 ", 1.0), ("-1e-3", -1e-3)]


@pytest.mark.parametrize(("value", "expected"), [*QUOTIENTS, (3, 3.0), (0.25, 0.25)])
def test_quotients(value, expected):
    assert quotient(value, "sensor.gain") == expected


@pytest.mark.parametrize(
    "value",
    ["12/0", "s", "1/s", "exp(-s)", "", "nan", "1/2s", True, None, [1], float("nan"), "1,5"],
)
def test_quotient_refuses(value):
    with pytest.raises(SpecError, match=r"^sensor\.gain "):
        quotient(value, "sensor.gain")


def test_a_written_common_factor_is_a_hidden_mode():
    assert hidden_modes(Plant.parse("(s-1)/((s-1)(s+2))")).tolist() == [1]
    assert hidden_modes(Plant.parse("1/(s+1) + 1/(s+1)")).tolist() == []
    assert hidden_modes(Plant.parse("(s+0.1)/((s+0.1)^2*(s+3))")).tolist() == [-0.1]


# Random formulas: a tree that is rendered to text and evaluated by exact rational arithmetic
# at a point, beside what the parser made of the text, evaluated at the same point.
decimals = st.decimals(min_value="0.001", max_value=999, places=3).map(str)
leaves = decimals.map(lambda d: (d, lambda s, d=d: F(d))) | st.just(("s", lambda s: s))


def _combined(children):
    def pair(operator):
        def join(ab):
            (a, fa), (b, fb) = ab
            text = f"({a}){operator}({b})"
            return text, lambda s: _applied(operator, fa(s), fb(s))

        return st.tuples(children, children).map(join)

    power = st.tuples(children, st.integers(-2, 3)).map(
        lambda ap: (f"({ap[0][0]})^{ap[1]}", lambda s: ap[0][1](s) ** ap[1])
    )
    negative = children.map(lambda a: (f"-({a[0]})", lambda s: -a[1](s)))
    return st.one_of(pair("+"), pair("-"), pair("*"), pair("/"), pair(""), power, negative)


def _applied(operator, a, b):
    return {"+": a + b, "-": a - b, "*": a * b, "": a * b}[operator] if operator != "/" else a / b


def _at(coefficients, s):
    value = F(0)
    for c in coefficients:
        value = value * s + c
    return value


def _outcome(text):
    """Return (what the formula says, None), or (None, why it is refused)."""
    try:
        return formula(text), None
    except SpecError as e:
        return None, str(e)


@given(st.recursive(leaves, _combined, max_leaves=8), st.fractions(-5, 5, max_denominator=97))
def test_any_formula_has_the_value_of_its_tree(tree, s):
    text, value_at = tree
    read, refused = _outcome(text)
    if read is None:
        assert any(why in refused for why in ("zero", "float", "order"))
        return
    num, den, delay = read
    try:
        expected = value_at(s)
    except ZeroDivisionError:
        return  # a pole of the formula, or of a part of it, at this point
    assert delay == 0
    if _at(den, s):  # else a zero and a pole that the formula writes meet here
        assert _at(num, s) / _at(den, s) == expected


coefficient = st.decimals(min_value=-1000, max_value=1000, places=4).map(F)


def _rendered(coefficients):
    n = len(coefficients) - 1
    return " + ".join(f"({float(c)!r}) s^{n - i}" for i, c in enumerate(coefficients))


@given(st.lists(coefficient, min_size=1, max_size=7), st.lists(coefficient, min_size=1, max_size=7))
def test_any_polynomials_come_back(num, den):
    if not any(den):
        return
    got_num, got_den, _ = formula(f"({_rendered(num)})/({_rendered(den)})")
    scale = next(c for c in den if c) / got_den[0]
    assert [c * scale for c in got_num] == _trimmed(num)
    assert [c * scale for c in got_den] == _trimmed(den)


def _trimmed(a):
    while len(a) > 1 and not a[0]:
        a = a[1:]
    return list(a)


@given(st.text(max_size=40) | st.text("s0123456789.+-*/^()exp eE", max_size=40))
def test_no_text_does_anything_else_than_a_value_or_one_line(text):
    read, refused = _outcome(text)
    if read is None:
        assert refused
        assert "\n" not in refused
    else:
        num, den, delay = read
        assert any(den)
        assert num
        assert delay >= 0

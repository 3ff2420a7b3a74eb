"""Every worked example: what comes of it, and what its source prints against what zoh finds."""

import json
from pathlib import Path

import numpy as np
import pytest

import zoh
import zoh.app.cli as cli
from zoh.app.files import beside, read_text
from zoh.app.project import read

EXAMPLES = Path(__file__).parents[2] / "examples"

MET = [
    "antenna_servo",
    "ball_and_beam",
    "cruise_control",
    "current_loop",
    "dc_motor_bode",
    "dc_motor_position",
    "dead_time_process",
    "disk_read_arm",
    "drone_pitch_rate",
    "hard_disk_head",
]
REFUSED = {"third_order_lag": ["fast PI"]}


def outcome(capsys, verb, name):
    code = cli.main([verb, str(EXAMPLES / f"{name}.toml"), "--json"])
    return code, json.loads(capsys.readouterr().out)


def sampled(name):
    file = str(EXAMPLES / f"{name}.toml")
    project = read(read_text(file), beside(file))
    return zoh.sample(project.plant, project.dt, project.compute_delay)


def printed(value, text):
    """Return whether a value rounds to the digits that a page prints."""
    mantissa, _, exponent = text.lower().partition("e")
    half = 0.5 * 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(value - float(text)) <= half * (1 + 1e-9)  # a decimal half is no float


@pytest.mark.parametrize("name", MET)
def test_examples_that_meet_what_their_source_asks(name, capsys):
    code, result = outcome(capsys, "design", name)
    assert code == 0
    assert all(d["met"] for d in result["designs"])


@pytest.mark.parametrize("name", REFUSED)
def test_examples_that_refuse_what_their_source_lets_pass(name, capsys):
    code, result = outcome(capsys, "design", name)
    assert code == 1
    assert [d["name"] for d in result["designs"] if not d["feasible"]] == REFUSED[name]


def test_the_ball_and_beam_as_printed_is_unstable_behind_its_margin(capsys):
    code, result = outcome(capsys, "check", "ball_and_beam_as_printed")
    assert code == 1
    lost, by_formula = result["designs"]
    assert not lost["margins"]["stable"]
    assert printed(lost["margins"]["phase_margin_deg"], "89.9")
    assert printed(by_formula["margins"]["phase_margin_deg"], "-2.1")
    # by hand: (z^2 + z) (z - 1)^2 + K (z + 1) (110 z^2 - 120 z + 10) has the factors z + 1, z - 1
    law = lost["controller"]
    plant = sampled("ball_and_beam_as_printed")
    closed = np.polyadd(np.polymul(law["den"], plant.den), np.polymul(law["num"], plant.num))
    assert abs(np.polyval(closed, 1.0)) < 1e-12
    assert abs(np.polyval(closed, -1.0)) < 1e-12


def test_the_sampled_plants_that_the_pages_print():
    car = sampled("cruise_control")
    assert printed(car.num[-1], "1.999e-05")
    assert printed(car.den[-1], "-0.999")
    ball = sampled("ball_and_beam")
    assert all(printed(c, "4.2e-05") for c in ball.num)
    speed = sampled("dc_motor_speed")
    assert printed(speed.num[0], "0.0020586")
    assert printed(speed.zeros()[0].real, "-0.8189")
    assert [printed(*p) for p in zip(sorted(speed.poles().real), ("0.6066", "0.9047"), strict=True)]
    motor = sampled("dc_motor_position")
    assert printed(motor.num[0], "0.0010389")
    assert printed(min(motor.zeros().real), "-0.9831")
    assert printed(max(motor.zeros().real), "-9.256e-07")
    assert printed(sorted(motor.poles().real)[1], "0.9425")
    head = sampled("hard_disk_head").poles()
    assert printed(head[0].real, "0.987")
    assert printed(abs(head[0].imag), "0.157")


def test_the_tuner_that_returns_less_than_it_was_asked_for():
    # its printed gains in continuous time; three digits of Kp are 0.18 % of |L|, some 0.1 deg
    for gains, wc, pm_deg in (([1.14, 0.454], 0.5205, 60.0), ([2.83, 0.0495], 1.0, 43.9973)):
        m = zoh.margins(zoh.Plant(num=gains, den=[1, 3, 3, 1, 0]))
        assert m.crossover == pytest.approx(wc, rel=3e-3)
        assert m.phase_margin_deg == pytest.approx(pm_deg, abs=0.1)


def test_the_gain_margin_that_a_plot_of_a_dead_time_gives():
    m = zoh.margins(zoh.Plant(num=[1], den=[10, 1], dead_time=5))  # in minutes, as the book
    assert printed(m.gain_margin, "3.8")
    assert printed(1 / m.gain_margin, "0.26")
    # by hand: atan(10 w) + 5 w = pi, which the plot's 0.36 misses by 2 %
    assert np.arctan(10 * m.phase_crossover) + 5 * m.phase_crossover == pytest.approx(np.pi)
    assert m.phase_crossover == pytest.approx(0.36, rel=0.03)  # read off a plot


def test_the_rule_of_one_and_a_half_samples_forgets_the_integral(capsys):
    dt, inductance, pm = 5e-5, 1e-3, np.radians(60)
    wc = (np.pi / 2 - pm) / (1.5 * dt)
    kp, ki = wc * inductance, wc * inductance * wc / 10
    code, result = outcome(capsys, "design", "current_loop")
    assert code == 0
    rule = result["designs"][0]
    exact = [kp + ki * dt / 2, -kp + ki * dt / 2]
    assert rule["controller"]["num"] == pytest.approx(exact, rel=1e-5)  # as written, five digits
    assert printed(rule["margins"]["phase_margin_deg"], "54.9")
    # what it leaves out is the integral's lag, less what the resistance gives back
    lag = np.degrees(np.arctan(ki / kp / wc) - np.arctan(0.1 / inductance / wc))
    # and |L| is 1 a little higher, where 1.5 samples and the integral turn otherwise: 0.3 deg
    assert rule["margins"]["phase_margin_deg"] == pytest.approx(60 - lag, abs=0.3)


def test_the_delay_of_a_drone_is_the_peak_of_its_response_and_no_dead_time():
    # exp(-2 t) sin(5 t) is the impulse response of 5/(s^2 + 4 s + 29); its peak, by hand
    peak = np.arctan(5 / 2) / 5
    assert printed(peak, "0.24")
    t = np.linspace(0, 1, 100_001)
    assert t[np.argmax(np.exp(-2 * t) * np.sin(5 * t))] == pytest.approx(peak, abs=1e-5)  # the grid
    late = zoh.Plant(num=[5], den=[1, 4, 29], dead_time=0.25)
    with pytest.raises(zoh.Infeasible, match="needs -174 deg"):
        zoh.pid(late, dt=0.02, compute_delay=0.02, wc=10, pm_deg=55, ki=50)

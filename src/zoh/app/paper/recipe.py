"""The paper's own recipe, kept as it was printed, mistakes included.

It takes the sampled plant at the real frequency wc, z = exp(j wc dt), and then puts this wc,
and not v = (2/dt) tan(wc dt/2), into the w-plane formulas. The library does not design like
this (see ``zoh.design``); it lives here so that every printed number can be recomputed.
Source: the paper, equations (1) to (21); they follow Phillips and Nagle.
"""

from cmath import phase
from collections.abc import Mapping
from dataclasses import dataclass
from math import atan, cos, degrees, log, pi, radians, sin, tau

from zoh.lti.systems import Plant, Sampled
from zoh.sampling.hold import sample

MOTOR_AND_GEAR = Plant(num=(2.3,), den=(1.0, 0.7809, 0.0))  # deg/V
POTENTIOMETER = 12 / 180  # V/deg, sec. II: 12 V over 180 deg
ARM = Plant(num=MOTOR_AND_GEAR.num, den=MOTOR_AND_GEAR.den, sensor=POTENTIOMETER)
DT = 0.1  # s


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """One controller of the paper, unrounded.

    law         none, lag, lead, pi or pid, as the paper calls it
    parameters  every intermediate number that the paper prints on the way, by printed key
    gains       what describes the controller, in SI units
    controller  D(z)
    """

    law: str
    parameters: Mapping[str, float]
    gains: Mapping[str, float]
    controller: Sampled


def first_order(a0: float, w0: float, wp: float) -> tuple[float, float, float]:
    """Return (gain, zero, pole) in z of a0 (1 + w/w0)/(1 + w/wp), equation (1).

    >>> gain, zero, pole = first_order(2.0, 20.0, 20.0)  # zero and pole meet: D = 2
    >>> gain, zero == pole
    (2.0, True)
    """
    c = 2 / DT
    gain = a0 * wp * (w0 + c) / (w0 * (wp + c))
    return gain, (c - w0) / (c + w0), (c - wp) / (c + wp)


def lag(*, wc: float, dc_gain: float) -> Recipe:
    """Return the controller of section III: w0 = 0.1 wc, wp = w0/(a0 |G(j wc)|)."""
    w0 = 0.1 * wc
    wp = w0 / (dc_gain * abs(_response(wc)))
    gain, zero, pole = first_order(dc_gain, w0, wp)
    controller = Sampled(num=(gain, -gain * zero), den=(1.0, -pole), dt=DT)
    corners = {"w0": w0, "wp": wp}
    gains = {"dc_gain": dc_gain, **corners}
    return Recipe(law="lag", parameters=corners, gains=gains, controller=controller)


def lead(*, wc: float, pm_deg: float, dc_gain: float, v: float | None = None) -> Recipe:
    """Return the controller of section IV, equations (5) and (6).

    ``v`` is the frequency put into the w-plane formulas; the paper puts wc, which is None here.
    """
    g, theta = abs(_response(wc)), _theta_r(wc, pm_deg)
    v = wc if v is None else v
    a1 = (1 - dc_gain * g * cos(theta)) / (v * g * sin(theta))
    b1 = (cos(theta) - dc_gain * g) / (v * sin(theta))
    w0, wp = dc_gain / a1, 1 / b1
    gain, zero, pole = first_order(dc_gain, w0, wp)
    parameters = {"theta_r_deg": degrees(theta), "cos_theta_r": cos(theta), "a1": a1, "b1": b1}
    parameters |= {"w0": w0, "wp": wp, "D_gain": gain, "D_zero": zero, "D_pole": pole}
    controller = Sampled(num=(gain, -gain * zero), den=(1.0, -pole), dt=DT)
    gains = {"dc_gain": dc_gain, "w0": w0, "wp": wp}
    return Recipe(law="lead", parameters=parameters, gains=gains, controller=controller)


def proportional_integral(*, wc: float, pm_deg: float) -> Recipe:
    """Return the controller of section V, equations (10) and (11)."""
    g, theta = abs(_response(wc)), _theta_r(wc, pm_deg)
    kp, ki = cos(theta) / g, -wc * sin(theta) / g
    half = ki * DT / 2
    return Recipe(
        law="pi",
        parameters={"theta_r_deg": degrees(theta), "KP": kp, "KI": ki},
        gains={"kp": kp, "ki": ki},
        controller=Sampled(num=(kp + half, half - kp), den=(1.0, -1.0), dt=DT),
    )


def three_terms(*, wc: float, pm_deg: float, ki: float) -> Recipe:
    """Return the controller of section VI, equations (19) and (20), solved for KD and KP."""
    g, theta = abs(_response(wc)), _theta_r(wc, pm_deg)
    c = 2 / DT
    kd = (sin(theta) / g + ki / wc) * (c**2 + wc**2) / (wc * c**2)
    kp = cos(theta) / g - kd * wc**2 * c / (c**2 + wc**2)
    half, slope = ki * DT / 2, kd / DT
    return Recipe(
        law="pid",
        parameters={"theta_r_deg": degrees(theta), "KP": kp, "KD": kd},
        gains={"kp": kp, "ki": ki, "kd": kd},
        controller=Sampled(
            num=(kp + half + slope, half - kp - 2 * slope, slope), den=(1.0, -1.0, 0.0), dt=DT
        ),
    )


def nothing() -> Recipe:
    """Return D(z) = 1."""
    unity = Sampled(num=(1.0,), den=(1.0,), dt=DT)
    return Recipe(law="none", parameters={}, gains={}, controller=unity)


def sample_time_behind(pole_s: float, pole_z: float) -> float:
    """Return the sample time in s that takes a pole at -pole_s rad/s to pole_z.

    >>> sample_time_behind(log(4), 0.5)
    0.5
    """
    return -log(pole_z) / pole_s


def crossover_behind(theta_r_deg: float, pm_deg: float) -> float:
    """Return the wc in rad/s whose theta_r this is: the plant's phase falls, so bisect."""
    low, high = 1e-6, pi / DT - 1e-6
    while high - low > 1e-12 * high:
        middle = (low + high) / 2
        below = degrees(_theta_r(middle, pm_deg)) < theta_r_deg
        low, high = (middle, high) if below else (low, middle)
    return (low + high) / 2


def integral_gain_behind(kd: float, *, wc: float, pm_deg: float) -> float:
    """Return the KI that makes equation (20) give this KD."""
    g, theta = abs(_response(wc)), _theta_r(wc, pm_deg)
    c = 2 / DT
    return wc * (kd * wc * c**2 / (c**2 + wc**2) - sin(theta) / g)


def turn_in_w(v: float, *, w0: float, wp: float) -> float:
    """Return the phase in degrees of (1 + w/w0)/(1 + w/wp) at w = j v: above 0 it is a lead.

    >>> round(turn_in_w(1.0, w0=1.0, wp=1e9), 6)
    45.0
    """
    return degrees(atan(v / w0) - atan(v / wp))


def _response(wc: float) -> complex:
    return sample(ARM, DT).at(wc)


def _theta_r(wc: float, pm_deg: float) -> float:
    """Return 180 deg + pm - arg G in rad, with arg G in (-360, 0] as the paper counts it."""
    angle = phase(_response(wc))
    return radians(180 + pm_deg) - (angle - tau if angle > 0 else angle)

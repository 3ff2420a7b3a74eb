"""The gains of a P, PI, PD or PID as each book writes them, all in the w-plane; poles that ring.

    parallel   kp + ki/w + kd w/(1 + w/p)
    standard   kp (1 + 1/(ti w) + td w/(1 + w td/n))                     n = td p
    series     k (1 + 1/(ti w)) (1 + td w)/(1 + w/p)

The three are one controller with one filter pole p, in rad/s at w = -p; times are in s. The
series form needs real zeros, (kp + ki/p)^2 >= 4 ki (kd + kp/p), which without a filter is
Ti >= 4 Td; of its two times the longer one is ti.
Source: K. J. Astrom and T. Hagglund, Advanced PID Control, sec. 3.2 (parallel, standard and
series form); here with the filter counted.
"""

from collections.abc import Mapping
from math import sqrt
from typing import Any

from zoh.lti.systems import Sampled
from zoh.lti.written import number

RINGS = 3.0  # times 2/dt: from there on a pole is below z = -1/2
_POLES = ("filter_pole", "wp", "lag_pole", "lead_pole")  # gains that are poles of their law
_REAL = 1e-4  # of a pole: a double one on the real axis is found as a pair as near as that


def time_constant(filter_pole: float | None, dt: float) -> float:
    """Return 1/p in s; dt/2 to the last bit where p is 2/dt or is left open.

    >>> time_constant(None, 0.1), time_constant(2 / 0.1, 0.1), time_constant(50.0, 0.1)
    (0.05, 0.05, 0.02)
    """
    return dt / 2 if filter_pole is None or filter_pole == 2 / dt else 1 / filter_pole


def forms(gains: Mapping[str, float]) -> dict[str, Any]:
    """Return each form by name, None where it does not exist, and why; {} for other gains.

    >>> found = forms({"kp": 3.0, "ki": 1.0, "kd": 1.0, "filter_pole": 2.0})
    >>> found["standard"]
    {'kp': 3.0, 'ti': 3.0, 'td': 0.333..., 'n': 0.666...}
    >>> found["series"]  # (1 + 2.5 w)(1 + w)/(w (1 + w/2)): 3/2 + 1 = 2.5, 3 + 1/2 = 2.5 + 1
    {'k': 2.5, 'ti': 2.5, 'td': 1.0, 'filter_pole': 2.0}
    >>> forms({"kp": 1.0, "ki": 1.0, "kd": 1.0, "filter_pole": 1e3})["refused"]
    {'series': 'zeros are complex: ... 1.002 is below 4.004'}
    """
    kp, ki, kd = gains.get("kp", 0.0), gains.get("ki", 0.0), gains.get("kd", 0.0)
    if not kp or (kd and not gains.get("filter_pole")):
        return {}
    standard = {"kp": kp}
    if ki:
        standard["ti"] = kp / ki
    if kd:
        standard |= {"td": kd / kp, "n": kd / kp * gains["filter_pole"]}
    series, why = _series(kp, ki, kd, gains.get("filter_pole"))
    refused = {} if why is None else {"series": why}
    return {"parallel": dict(gains), "standard": standard, "series": series, "refused": refused}


def sentences(gains: Mapping[str, float]) -> list[str]:
    """Return a line for the standard form and one for the series form, for people.

    >>> sentences({"kp": 3.0, "ki": 1.0})
    ['standard form: kp = 3, ti = 3', 'series form: k = 3, ti = 3']
    """
    found = forms(gains)
    lines = []
    for name in ("standard", "series") if len(gains) > 1 and found else ():
        form = found[name]
        shown = found["refused"].get(name) or ", ".join(
            f"{k} = {number(v)}" for k, v in form.items()
        )
        lines.append(f"{name} form: {shown}")
    return lines


def ringing(gains: Mapping[str, float], dt: float) -> list[str]:
    """Return a line for each pole of a law so fast that it rings from sample to sample.

    >>> ringing({"kp": 1.0, "kd": 1.0, "filter_pole": 380.0}, 0.1)
    ['filter_pole = 380 is far above 2/dt = 20: its pole at z = -0.9 rings at every sample']
    """
    return [
        f"{name} = {gains[name]:g} is far above 2/dt = {2 / dt:g}: its pole at "
        f"z = {pole:.4g} rings at every sample"
        for name, pole in _named(gains, dt).items()
    ]


def ringing_poles(controller: Sampled, gains: Mapping[str, float]) -> list[str]:
    """Return the lines of ``ringing``, and one for each other pole of the controller that rings.

    >>> ringing_poles(Sampled(num=[1.0, 0.0], den=[1.0, 0.9], dt=0.1), {})
    ['a pole of the controller at z = -0.9 rings at every sample']
    """
    found = [
        float(pole.real)
        for pole in controller.poles()
        if pole.real < (1 - RINGS) / (1 + RINGS) and abs(pole.imag) < _REAL * abs(pole)
    ]
    for known in _named(gains, controller.dt).values():
        if found:
            found.remove(min(found, key=lambda pole: abs(pole - known)))
    others = [f"a pole of the controller at z = {pole:.4g} rings at every sample" for pole in found]
    return [*ringing(gains, controller.dt), *others]


def _named(gains: Mapping[str, float], dt: float) -> dict[str, float]:
    """Return the poles in z of a law that ring, by the name of the gain."""
    halves = {name: gains[name] * dt / 2 for name in _POLES if name in gains}
    return {name: (1 - half) / (1 + half) for name, half in halves.items() if half > RINGS}


def _series(
    kp: float, ki: float, kd: float, pole: float | None
) -> tuple[dict[str, float] | None, str | None]:
    """Return the series form or None, and why it is None."""
    if pole is None:  # P and PI: one factor
        return ({"k": kp, "ti": kp / ki} if ki else {"k": kp}), None
    top, middle = kd + kp / pole, kp + ki / pole
    if not ki:
        return {"k": kp, "td": top / kp, "filter_pole": pole}, None
    room = middle * middle - 4 * ki * top
    if room < 0:
        return None, (
            "zeros are complex: (kp + ki/p)^2 must be at least 4 ki (kd + kp/p), and "
            f"{middle * middle:.4g} is below {4 * ki * top:.4g}"
        )
    twice = middle + sqrt(room)  # = 2 k, as ki ti = k and k td = top
    return {"k": twice / 2, "ti": twice / 2 / ki, "td": 2 * top / twice, "filter_pole": pole}, None

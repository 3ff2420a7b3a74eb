"""One verified controller of each shape, for the tests of firmware."""

from functools import cache

import zoh
from zoh.firmware.plan import plan

ARM = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
LAWS = ("p", "pi", "pd", "pid", "pid_filtered", "lag", "lead", "leadlag", "notched", "given")


@cache
def design(law):
    """Return a verified design of this law, on the paper's arm."""
    if law == "p":
        return zoh.p(ARM, dt=0.1, pm_deg=40)
    if law == "pi":
        return zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    if law == "pd":
        return zoh.pd(ARM, dt=0.1, wc=2.5, pm_deg=50, filter_pole=40.0)
    if law == "pid":
        return zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    if law == "pid_filtered":
        return zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, filter_pole=60.0)
    if law == "lag":
        return zoh.lag(ARM, dt=0.1, wc=0.7, pm_deg=40, dc_gain=10)
    if law == "lead":
        return zoh.lead(ARM, dt=0.1, wc=2.5, pm_deg=40, dc_gain=10)
    if law == "leadlag":
        return zoh.leadlag(ARM, dt=0.1, wc=1.95, pm_deg=40, dc_gain=100)
    if law == "notched":
        notch = zoh.notch(w0=12.0)
        return zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, filter_pole=60.0, sections=[notch])
    # a pole at z = 0 beside a zero at infinity, as hand-written controllers have
    given = zoh.Sampled(num=[20.0, -17.0], den=[1.0, -0.4, 0.0], dt=0.1)
    return zoh.verify(ARM, given)


def made(law, number, **options):
    """Return its plan within +-12 V, measured over +-12 V."""
    limits = {"u_min": -12.0, "u_max": 12.0, "y_range": (-12, 12), "name": "ctl"} | options
    return plan(design(law), number=number, **limits)

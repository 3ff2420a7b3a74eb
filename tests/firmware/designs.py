"""One verified controller of each shape, for the tests of firmware."""

from functools import cache

from benchmarks.firmware_equality import ARM
from benchmarks.firmware_equality import design as of_law

import zoh
from zoh.firmware.plan import plan

LAWS = ("p", "pi", "pd", "pid", "pid_filtered", "lag", "lead", "leadlag", "notched", "given")


@cache
def design(law):
    """Return a verified design of this law, on the paper's arm."""
    if law == "pid":
        return zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    if law != "given":
        return of_law("pid" if law == "pid_filtered" else law)
    # a pole at z = 0 beside a zero at infinity, as hand-written controllers have
    given = zoh.Sampled(num=[20.0, -17.0], den=[1.0, -0.4, 0.0], dt=0.1)
    return zoh.verify(ARM, given)


def made(law, number, **options):
    """Return its plan within +-12 V, measured over +-12 V."""
    limits = {"u_min": -12.0, "u_max": 12.0, "y_range": (-12, 12), "name": "ctl"} | options
    return plan(design(law), number=number, **limits)

"""Every law in every number format, proved equal to its model on every core at both levels.

    python -m benchmarks.firmware_equality [--laws pid,lead] [--numbers q15,f32] [--limit SECONDS]

prints one line for each controller, the cost on three cores and, in whole numbers, how long a
solver took to exclude overflow; exits with 1 where a bit differs, where overflow is not excluded
or, with --limit, where one proof of equality takes longer than that.
"""

import sys
from argparse import ArgumentParser
from time import perf_counter, process_time

import zoh
from zoh.firmware.lines import NUMBERS
from zoh.firmware.plan import Plan
from zoh.firmware.solver import overflow_excluded

ARM = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
LAWS = ("p", "pd", "pi", "pid", "lag", "lead", "leadlag", "notched")
SHOWN = ("Cortex-M0+", "Cortex-M4F", "RV32IMAC")


def design(law: str) -> object:
    """Return a verified design of this law on the robot arm."""
    if law == "p":
        return zoh.p(ARM, dt=0.1, pm_deg=40)
    if law == "pd":
        return zoh.pd(ARM, dt=0.1, wc=2.5, pm_deg=50, filter_pole=40.0)
    if law == "pi":
        return zoh.pi(ARM, dt=0.1, wc=0.8, pm_deg=40)
    if law == "lag":
        return zoh.lag(ARM, dt=0.1, wc=0.7, pm_deg=40, dc_gain=10)
    if law == "lead":
        return zoh.lead(ARM, dt=0.1, wc=2.5, pm_deg=40, dc_gain=10)
    if law == "leadlag":
        return zoh.leadlag(ARM, dt=0.1, wc=1.95, pm_deg=40, dc_gain=100)
    sections = [zoh.notch(w0=12.0)] if law == "notched" else []
    return zoh.pid(ARM, dt=0.1, wc=1.95, pm_deg=40, ki=0.85, filter_pole=60.0, sections=sections)


def planned(law: str, number: str) -> Plan:
    """Return its plan within +-12 V, with every feature that its realisation has."""
    return zoh.plan(
        design(law), name=law, number=number, u_min=-12.0, u_max=12.0, y_range=(-12, 12), rate=500.0
    )


def excluded(made: Plan) -> tuple[bool, str]:
    """Return whether overflow is excluded in a plan of whole numbers, and what that took."""
    if made.ranges is None:
        return True, ""
    start = process_time()
    holds = overflow_excluded(made)
    words = "excluded" if holds else "NOT excluded"
    return holds, f"; overflow {words} in {process_time() - start:.2f} s"


def main() -> int:
    """Prove what is asked for; return the exit code."""
    parser = ArgumentParser()
    parser.add_argument("--laws", default=",".join(LAWS))
    parser.add_argument("--numbers", default=",".join(NUMBERS))
    parser.add_argument("--limit", type=float, default=float("inf"))
    arguments = parser.parse_args()
    wrong = 0
    for number in arguments.numbers.split(","):
        for law in arguments.laws.split(","):
            made, start = planned(law, number), perf_counter()
            try:
                found = zoh.prove(made)
            except zoh.Unequal as differs:
                found, wrong = differs.found, wrong + 1
                print(differs)
            seconds = perf_counter() - start
            wrong += seconds > arguments.limit
            holds, overflow = excluded(made)
            wrong += not holds
            costs = ", ".join(
                f"{b.target} {b.instructions[1]:.0f} ({b.instructions[2]})"
                for b in found.builds
                if b.target in SHOWN and b.level == "O2" and b.instructions
            )
            print(
                f"{law:8} {number:4} {made.realisation:8} {len(found.builds)} builds, "
                f"{len(found.differences)} differences, {seconds:5.1f} s; {costs}{overflow}",
                flush=True,
            )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())

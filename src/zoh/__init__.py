"""zoh: digital controllers that provably meet their specification.

A plant and a specification go in, a verified controller comes out::

    arm = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
    d = zoh.pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    print(d.report())
"""

from importlib import import_module
from typing import TYPE_CHECKING

import zoh.design as _laws  # before the function of the same name below, which it would hide

if TYPE_CHECKING:
    from zoh.analysis.budget import Budget, budget
    from zoh.analysis.certificates import Certificate, Proof
    from zoh.analysis.closed import EXCITATIONS
    from zoh.analysis.curves import Trace, trace
    from zoh.analysis.margins import margins
    from zoh.analysis.responses import Response, noise_gains, response, response_trace
    from zoh.analysis.results import Margins, StepInfo
    from zoh.analysis.step import step_info
    from zoh.analysis.tabled.results import TableMargins
    from zoh.analysis.tabled.verify import (
        TableMeasured,
        TableVerified,
        measure_table,
        verify_table,
    )
    from zoh.analysis.verify import Measured, Verified, measure, verify
    from zoh.batch.job import Job
    from zoh.batch.reason import Reason
    from zoh.batch.result import Sweep
    from zoh.batch.robust import Robust, robust
    from zoh.batch.sources import Geared, Roots
    from zoh.batch.space import Grid, Random, Rows, corners
    from zoh.batch.spread import LogUniform, Normal, Uniform
    from zoh.batch.stream import open_sweep, sweep_to
    from zoh.batch.summary import Summary
    from zoh.batch.sweep import sweep, sweep_summary
    from zoh.choice.map import Map, law_map
    from zoh.clock import SampleTime, SampleTimes, sample_times
    from zoh.design.sections import SecondOrder, notch
    from zoh.emulation import Emulated, emulate
    from zoh.errors import AccuracyWarning, Infeasible, NotMet, SpecError, Unequal, ZohError
    from zoh.firmware.equality import Equality
    from zoh.firmware.export import export
    from zoh.firmware.plan import Plan, plan
    from zoh.firmware.prove import prove
    from zoh.laws import lag, lead, leadlag, p, pd, pi, pid, textbook_lag
    from zoh.lti.coherence import random_error
    from zoh.lti.frequency_response import FrequencyResponse, TabledLoop
    from zoh.lti.joint import Joint
    from zoh.lti.systems import Plant, Sampled
    from zoh.pipeline import design
    from zoh.request import ALLOWABLE, LAWS, OPTIONS
    from zoh.sampling.convert import METHODS, discretise, undiscretise
    from zoh.sampling.hold import sample
    from zoh.spec import Crossover, Requirements

__version__ = "0.1.0"

__all__ = [
    "ALLOWABLE",
    "EXCITATIONS",
    "LAWS",
    "METHODS",
    "OPTIONS",
    "AccuracyWarning",
    "Budget",
    "Certificate",
    "Crossover",
    "Emulated",
    "Equality",
    "FrequencyResponse",
    "Geared",
    "Grid",
    "Infeasible",
    "Job",
    "Joint",
    "LogUniform",
    "Map",
    "Margins",
    "Measured",
    "Normal",
    "NotMet",
    "Plan",
    "Plant",
    "Proof",
    "Random",
    "Reason",
    "Requirements",
    "Response",
    "Robust",
    "Roots",
    "Rows",
    "SampleTime",
    "SampleTimes",
    "Sampled",
    "SecondOrder",
    "SpecError",
    "StepInfo",
    "Summary",
    "Sweep",
    "TableMargins",
    "TableMeasured",
    "TableVerified",
    "TabledLoop",
    "Trace",
    "Unequal",
    "Uniform",
    "Verified",
    "ZohError",
    "budget",
    "corners",
    "design",
    "discretise",
    "emulate",
    "export",
    "lag",
    "law_map",
    "lead",
    "leadlag",
    "margins",
    "measure",
    "measure_table",
    "noise_gains",
    "notch",
    "open_sweep",
    "p",
    "pd",
    "pi",
    "pid",
    "plan",
    "prove",
    "random_error",
    "response",
    "response_trace",
    "robust",
    "sample",
    "sample_times",
    "step_info",
    "sweep",
    "sweep_summary",
    "sweep_to",
    "textbook_lag",
    "trace",
    "undiscretise",
    "verify",
    "verify_table",
]

# A name is loaded when it is first used: what a script does not need costs it nothing. The
# imports above say the same to type checkers, and a test compares the two.
_HOMES = {
    "zoh.analysis.budget": ("Budget", "budget"),
    "zoh.analysis.closed": ("EXCITATIONS",),
    "zoh.analysis.margins": ("margins",),
    "zoh.analysis.responses": ("Response", "noise_gains", "response", "response_trace"),
    "zoh.analysis.curves": ("Trace", "trace"),
    "zoh.analysis.certificates": ("Certificate", "Proof"),
    "zoh.analysis.results": ("Margins", "StepInfo"),
    "zoh.analysis.step": ("step_info",),
    "zoh.analysis.tabled.results": ("TableMargins",),
    "zoh.analysis.tabled.verify": (
        "TableMeasured",
        "TableVerified",
        "measure_table",
        "verify_table",
    ),
    "zoh.analysis.verify": ("Measured", "Verified", "measure", "verify"),
    "zoh.request": ("ALLOWABLE", "LAWS", "OPTIONS"),
    "zoh.batch.job": ("Job",),
    "zoh.batch.reason": ("Reason",),
    "zoh.batch.result": ("Sweep",),
    "zoh.batch.robust": ("Robust", "robust"),
    "zoh.batch.sources": ("Geared", "Roots"),
    "zoh.batch.space": ("Grid", "Random", "Rows", "corners"),
    "zoh.batch.spread": ("LogUniform", "Normal", "Uniform"),
    "zoh.batch.stream": ("open_sweep", "sweep_to"),
    "zoh.batch.summary": ("Summary",),
    "zoh.batch.sweep": ("sweep", "sweep_summary"),
    "zoh.design.sections": ("SecondOrder", "notch"),
    "zoh.choice.map": ("Map", "law_map"),
    "zoh.clock": ("SampleTime", "SampleTimes", "sample_times"),
    "zoh.emulation": ("Emulated", "emulate"),
    "zoh.errors": ("Infeasible", "NotMet", "AccuracyWarning", "SpecError", "Unequal", "ZohError"),
    "zoh.firmware.equality": ("Equality",),
    "zoh.firmware.export": ("export",),
    "zoh.firmware.plan": ("Plan", "plan"),
    "zoh.firmware.prove": ("prove",),
    "zoh.lti.coherence": ("random_error",),
    "zoh.lti.frequency_response": ("FrequencyResponse", "TabledLoop"),
    "zoh.lti.joint": ("Joint",),
    "zoh.lti.systems": ("Plant", "Sampled"),
    "zoh.laws": ("lag", "lead", "leadlag", "p", "pd", "pi", "pid", "textbook_lag"),
    "zoh.pipeline": ("design",),
    "zoh.sampling.convert": ("METHODS", "discretise", "undiscretise"),
    "zoh.sampling.hold": ("sample",),
    "zoh.spec": ("Crossover", "Requirements"),
}
_ROOMS = (
    "analysis",
    "batch",
    "certificate",
    "checks",
    "emulation",
    "errors",
    "laws",
    "firmware",
    "lti",
    "pipeline",
    "request",
    "sampling",
    "spec",
)
_HOME = {name: home for home, names in _HOMES.items() for name in names}
del globals()["design"], _laws  # the package stays importable; the name is the function's


def __getattr__(name: str) -> object:
    if name in _ROOMS:
        return import_module(f"zoh.{name}")
    if name not in _HOME:
        raise AttributeError(f"zoh has no {name!r}; it has {', '.join(__all__)}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])

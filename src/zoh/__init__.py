"""zoh: digital controllers that provably meet their specification.

A plant and a specification go in, a verified controller comes out::

    arm = zoh.Plant.parse("2.3/(s^2 + 0.7809 s)", sensor=12 / 180)
    d = zoh.pid(arm, dt=0.1, wc=1.95, pm_deg=40, ki=0.85)
    print(d.report())
"""

from zoh.analysis.closed import EXCITATIONS
from zoh.analysis.margins import margins
from zoh.analysis.responses import Response, noise_gains, response, response_trace
from zoh.analysis.results import Margins, StepInfo
from zoh.analysis.step import Trace, step_info, trace
from zoh.analysis.verify import Measured, Verified, measure, verify
from zoh.certificate import LAWS
from zoh.errors import Infeasible, NotMet, SpecError, ZohError
from zoh.lti.systems import Plant, Sampled
from zoh.pipeline import design, lag, lead, p, pd, pi, pid
from zoh.sampling.convert import METHODS, discretise, undiscretise
from zoh.sampling.hold import sample
from zoh.spec import Crossover, Requirements

__version__ = "0.1.0"

__all__ = [
    "EXCITATIONS",
    "LAWS",
    "METHODS",
    "Crossover",
    "Infeasible",
    "Margins",
    "Measured",
    "NotMet",
    "Plant",
    "Requirements",
    "Response",
    "Sampled",
    "SpecError",
    "StepInfo",
    "Trace",
    "Verified",
    "ZohError",
    "design",
    "discretise",
    "lag",
    "lead",
    "margins",
    "measure",
    "noise_gains",
    "p",
    "pd",
    "pi",
    "pid",
    "response",
    "response_trace",
    "sample",
    "step_info",
    "trace",
    "undiscretise",
    "verify",
]

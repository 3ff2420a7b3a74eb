"""What one loop of a batch is, and which of its numbers vary from loop to loop."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from zoh import checks
from zoh.analysis.results import Gains
from zoh.batch import sources
from zoh.batch.sources import Source
from zoh.design.sections import SecondOrder, listed
from zoh.errors import SpecError
from zoh.lti.sampled import sample_time
from zoh.lti.systems import Plant, Sampled
from zoh.lti.weights import WEIGHTS
from zoh.request import LAWS, OPTIONS, checked, left_open

GIVEN = "given"
_ANY = 2.0  # within the bounds of every parameter of a law


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """One loop: a plant, and a law with what it is asked for or a controller that is given.

    plant          a Plant, its Roots, or a Geared joint; with dead_time in s and the sensor
    law            a name of ``zoh.LAWS``, or "given"
    asked          the law's parameters by name (wc in rad/s, pm_deg, ki, dc_gain, ...); one that
                   varies need not be there
    controller     of a job that is "given": its coefficients in z, run at whatever dt is
    dt             s, sample time, None where it varies;  compute_delay  s, from sampling to output
    reference      the step asked of the loop, in the units that the controller compares
    sections       fixed second-order sections in series with the law
    varying        the keys of what varies, in the order of their columns

    Keys are "dt", "compute_delay", "dead_time" (s), the law's own parameters ("wc", "pm_deg",
    "ki", "dc_gain" ...), and the plant's numbers as ``zoh.batch.sources`` names them
    ("plant.gain", "plant.den.1", "plant.pole.0", "plant.joint.load_inertia" ...). "plant.gain" is
    num[0]/den[0], so that of 2/(10 s + 1) is 0.2; it is not the gain at rest.
    Raises SpecError for what is no loop, or a key that this one does not have.

    >>> arm = Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
    >>> job = Job(plant=arm, law="pi", asked={"pm_deg": 40}, dt=0.1, varying=("wc", "plant.den.1"))
    >>> job.value("plant.den.1"), job.value("pm_deg")
    (0.7809, 40.0)
    """

    plant: Source
    law: str
    dt: float | None = None
    asked: Mapping[str, float] = field(default_factory=dict)
    controller: Sampled | None = None
    compute_delay: float = 0.0
    reference: float = 1.0
    sections: Sequence[SecondOrder] = ()
    varying: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        put = object.__setattr__
        sources.checked(self.plant)
        put(self, "varying", tuple(self.varying))
        if self.dt is not None:
            put(self, "dt", sample_time(self.dt))
        elif "dt" not in self.varying:
            raise SpecError("dt", "must be given or vary", None, "the sample time in seconds")
        put(self, "compute_delay", checks.not_negative("compute_delay", self.compute_delay))
        put(self, "reference", checks.number("reference", self.reference))
        if self.reference == 0:
            raise SpecError("reference", "must not be 0", 0.0, "a step of 0 shows nothing")
        put(self, "sections", listed(self.sections))
        self._check_law()
        self._check_varying()
        put(self, "asked", self._checked_asked())

    def value(self, key: str) -> float | None:
        """Return what a key is where it does not vary, None where nothing was given for it."""
        return self._values()[key]

    def keys(self) -> tuple[str, ...]:
        """Return every key that can vary in this loop."""
        return tuple(self._values())

    @property
    def clock(self) -> dict[str, float]:
        """Return the times in s that are given; one that varies need not be."""
        delays = {"compute_delay": self.compute_delay, "dead_time": self.plant.dead_time}
        return delays if self.dt is None else {"dt": self.dt, **delays}

    @property
    def law_keys(self) -> tuple[str, ...]:
        """Return the parameters that the law takes, those it can do without included."""
        return LAWS.get(self.law, ()) + OPTIONS.get(self.law, ())

    def _values(self) -> dict[str, float | None]:
        law = {name: self.asked.get(name) for name in self.law_keys}
        return {"dt": None, **self.clock, **law, **sources.nominal(self.plant)}

    def _check_law(self) -> None:
        if not isinstance(self.law, str) or self.law not in (*LAWS, GIVEN):
            way_out = "choose one of these"
            names = ", ".join((*LAWS, GIVEN))
            raise SpecError("law", f"must be one of {names}", self.law, way_out)
        fits = isinstance(self.controller, Sampled) or self.controller is None
        if not fits or (self.law == GIVEN) != (self.controller is not None):
            way_out = 'law="given" takes a zoh.Sampled as controller, the other laws take none'
            raise SpecError("controller", "must fit the law", self.controller, way_out)

    def _checked_asked(self) -> Gains:
        if not isinstance(self.asked, Mapping):
            way_out = '{"pm_deg": 50}, each parameter that does not vary'
            raise SpecError("asked", "must name the law's parameters", self.asked, way_out)
        if self.law == GIVEN:
            if self.asked:
                raise SpecError("asked", "must be left out", dict(self.asked), "nothing is solved")
            return Gains({})
        told = {**self.asked, **{k: _ANY for k in self.varying if k in self.law_keys}}
        parameters = checked(self.law, told)
        if missing := left_open(self.law, parameters):
            way_out = f"{self.law} takes {', '.join(self.law_keys)}; a batch chooses nothing"
            raise SpecError(missing[0], "must be given or vary", None, way_out)
        return Gains({k: v for k, v in parameters.items() if k in self.asked})

    def _check_varying(self) -> None:
        keys = self.keys()
        for i, key in enumerate(self.varying):
            if key not in keys:
                raise SpecError("over", "must name what this loop has", key, ", ".join(keys))
            if key in self.varying[:i]:
                raise SpecError("over", "must name a key once", key, "leave the second one out")


def refuse_weights(asked: Mapping[str, object], where: str) -> None:
    """Raise SpecError where the reference is weighted and the controller alone is to be run.

    Its coefficients do not say how the reference enters, so its step would be another one's.
    """
    for name in WEIGHTS:
        weight = asked.get(name, 1.0)
        if not (isinstance(weight, int | float) and weight == 1):
            way_out = "leave it out, or let the law be designed in every loop"
            raise SpecError(name, f"must be 1 for {where}", weight, way_out)


__all__ = ["GIVEN", "Job", "Plant", "refuse_weights"]

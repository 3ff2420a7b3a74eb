"""What was measured: values that know their JSON form."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import inf, isinf, log10
from typing import Any

from zoh.analysis.certificates import Certificate


@dataclass(frozen=True, slots=True, kw_only=True)
class Margins:
    """The margins of a loop L in unity negative feedback.

    stable            the closed loop's poles are all inside the stable region, proved either
                      way; None where no proof decides it, or a table of measured points does not
    gain_margin       the factor on L nearest 1 (in log) that makes the loop marginally stable;
                      inf where there is none
    phase_crossover   rad/s, where that happens; None where there is none
    phase_margin_deg  deg in (-180, 180], the smallest in magnitude; inf without a crossover
    crossover         rad/s, where that is; None where |L| never is 1
    delay_margin      s, the least extra delay tau over all gain crossovers whose exp(-j w tau)
                      makes the loop marginally stable; inf where there is none. Whole samples
                      are that exactly. Where |L| is 1 or more at the highest frequencies it is 0
                      for a continuous loop and at most dt for a sampled one: one extra sample
                      then ends its stability, whatever the crossovers say
    modulus_margin    min |1 + L|, at ms_frequency rad/s
    mt                max |L/(1 + L)|, at mt_frequency rad/s
    disk_margin       balanced (sigma = 0): min 2 |1 + L|/|1 - L|, at disk_frequency rad/s
    bandwidth         rad/s, where |T| is first 3 dB (a factor of 10^(-3/20)) below its value at
                      w = 0; None where it never is, or T is 0 there
    gain_crossings    every (frequency in rad/s, phase margin in deg)
    phase_crossings   every (frequency, gain factor); w = 0 and Nyquist's count where L is
                      negative real there. A continuous dead time turns the loop for ever:
                      listed are all with a factor up to 1000 and a few more; where |L| ends
                      at more than that, all up to within 1 % of its end; where these would be
                      too many, those up to 2, or around what decides the gain margin
    certificate       why no crossing was missed and no peak is higher; None for a table
    warnings          what the figures rest on or where they end, one sentence each
    dt                s, between two samples; None of a continuous loop
    """

    stable: bool | None
    gain_margin: float
    phase_crossover: float | None
    phase_margin_deg: float
    crossover: float | None
    delay_margin: float
    modulus_margin: float
    ms_frequency: float
    mt: float
    mt_frequency: float
    disk_margin: float
    disk_frequency: float
    bandwidth: float | None
    gain_crossings: tuple[tuple[float, float], ...]
    phase_crossings: tuple[tuple[float, float], ...]
    certificate: Certificate | None = None
    warnings: tuple[str, ...] = ()
    dt: float | None = None

    @property
    def delay_margin_samples(self) -> float | None:
        """The delay margin in samples; None of a continuous loop."""
        return self.delay_margin / self.dt if self.dt else None

    @property
    def gain_margin_db(self) -> float:
        """The gain margin in dB, 20 log10 of the ratio; negative where less gain is the limit."""
        return 20 * log10(self.gain_margin) if 0 < self.gain_margin < inf else self.gain_margin

    @property
    def ms(self) -> float:
        """The peak of the sensitivity, 1/modulus_margin."""
        return 1 / self.modulus_margin if self.modulus_margin else inf

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form: inf as "inf", what does not exist as None."""
        return {
            "stable": self.stable,
            "gain_margin": jsonable(self.gain_margin),
            "gain_margin_db": jsonable(self.gain_margin_db),
            "phase_crossover": jsonable(self.phase_crossover),
            "phase_margin_deg": jsonable(self.phase_margin_deg),
            "crossover": jsonable(self.crossover),
            "delay_margin": jsonable(self.delay_margin),
            "delay_margin_samples": jsonable(self.delay_margin_samples),
            "modulus_margin": jsonable(self.modulus_margin),
            "ms": jsonable(self.ms),
            "ms_frequency": jsonable(self.ms_frequency),
            "mt": jsonable(self.mt),
            "mt_frequency": jsonable(self.mt_frequency),
            "disk_margin": jsonable(self.disk_margin),
            "disk_frequency": jsonable(self.disk_frequency),
            "bandwidth": jsonable(self.bandwidth),
            "gain_crossings": [[jsonable(x) for x in c] for c in self.gain_crossings],
            "phase_crossings": [[jsonable(x) for x in c] for c in self.phase_crossings],
            "certificate": None if self.certificate is None else self.certificate.to_dict(),
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class StepInfo:
    """The response to a reference step, in the units of the reference.

    stable              whether it comes to rest at all; where not, nothing else exists
    overshoot_pct       % of the final value beyond it
    undershoot_pct      % of the final value on the other side of the start
    rise_time           s, from first reaching 10 % to first reaching 90 % of the final value
    settling_time       s, after which the response stays within 2 % of the final value
    peak, peak_time     how far it goes in the direction of its final value (in either, where that
                        is 0), a size of 0 or more, and when in s
    final_value         what it settles to
    steady_state_error  reference minus final value
    horizon             s, to which it was followed: until its slowest mode has fallen to 1e-10,
                        or as far as a million samples that matter go
    between_samples     the same, exactly, between the samples too; None where that is not known
    peak_effort         the largest |u| asked of the actuator, in input units; None for a bare T
    peak_effort_time    s, when that is; None where it is only approached
    effort_range        the least and the largest u; None for a bare T

    What does not exist is None: a percentage of a final value of 0; the settling time of a response
    that may leave its band after the horizon; the peak time of one that never passes its final
    value by more than 1e-10 of it, whether it creeps up to that for ever or is there from a sample
    on (a static gain, a deadbeat loop): of such the peak is the final value.
    """

    stable: bool = True
    overshoot_pct: float | None = None
    undershoot_pct: float | None = None
    rise_time: float | None = None
    settling_time: float | None = None
    peak: float | None = None
    peak_time: float | None = None
    final_value: float | None = None
    steady_state_error: float | None = None
    horizon: float | None = None
    between_samples: "StepInfo | None" = None
    peak_effort: float | None = None
    peak_effort_time: float | None = None
    effort_range: tuple[float, float] | None = None

    @property
    def settling(self) -> str:
        """The settling time in words, also where there is none.

        >>> StepInfo(settling_time=1.5).settling
        '1.5 s'
        >>> StepInfo(final_value=1.0, horizon=40.0).settling
        'not at rest by 40 s'
        >>> StepInfo(stable=False).settling
        'unstable'
        """
        if not self.stable:
            return "unstable"
        if self.settling_time is not None:
            return f"{self.settling_time:.4g} s"
        if not self.final_value:
            return "settles to 0"
        return f"not at rest by {self.horizon:.4g} s"

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form; what does not exist is None."""
        between, effort = self.between_samples, self.effort_range
        return {
            **self._figures(),
            "between_samples": None if between is None else between._figures(),
            "peak_effort": self.peak_effort,
            "peak_effort_time": self.peak_effort_time,
            "effort_range": None if effort is None else list(effort),
        }

    def _figures(self) -> dict[str, Any]:
        return {
            "stable": self.stable,
            "overshoot_pct": self.overshoot_pct,
            "undershoot_pct": self.undershoot_pct,
            "rise_time": self.rise_time,
            "settling_time": self.settling_time,
            "peak": self.peak,
            "peak_time": self.peak_time,
            "final_value": self.final_value,
            "steady_state_error": self.steady_state_error,
            "horizon": self.horizon,
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """What was left open of a request, and why it was closed as it was; a label, no evidence.

    open     the names of what was open: law, wc, pm_deg, ki, dc_gain
    assumed  the requirements that were assumed where none was given
    limits   what stands against a faster crossover, one sentence each
    tried    (law, why not) of the simpler laws that were tried first
    notes    what the requirements leave unsaid of the design that was chosen
    """

    open: tuple[str, ...]
    assumed: tuple[str, ...] = ()
    limits: tuple[str, ...] = ()
    tried: tuple[tuple[str, str], ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return the choice in words.

        >>> Choice(open=("wc",), limits=("above 2 rad/s ms must be at most 1.7",)).sentences
        ('chosen: wc, the fastest that meets everything', 'above 2 rad/s ms must be at most 1.7')
        """
        fastest = ", the fastest that meets everything" if "wc" in self.open else ""
        return (
            f"chosen: {', '.join(self.open)}{fastest}",
            *([f"assumed, nothing being asked: {', '.join(self.assumed)}"] if self.assumed else []),
            *self.limits,
            *self.notes,
            *(f"no {law}: {why}" for law, why in self.tried),
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {
            "open": list(self.open),
            "assumed": list(self.assumed),
            "limits": list(self.limits),
            "tried": [{"law": law, "why_not": why} for law, why in self.tried],
            "notes": list(self.notes),
        }


class Gains(Mapping[str, float]):
    """Gains by name, read-only; unlike a mapping proxy they can be pickled and hashed.

    Floats under texts: what others give is checked before it is put in here.
    """

    __slots__ = ("_items",)

    def __init__(self, items: Mapping[str, float]) -> None:
        self._items = tuple(items.items())

    def __getitem__(self, name: str) -> float:
        return dict(self._items)[name]

    def __iter__(self) -> Iterator[str]:
        return (name for name, _ in self._items)

    def __len__(self) -> int:
        return len(self._items)

    def __hash__(self) -> int:
        return hash(self._items)

    def __repr__(self) -> str:
        return repr(dict(self._items))


def jsonable(value: float | None) -> float | str | None:
    """Return ``value`` with infinity as "inf" or "-inf", as the JSON format has it.

    >>> jsonable(inf), jsonable(1.5), jsonable(None)
    ('inf', 1.5, None)
    """
    if value is not None and isinf(value):
        return "inf" if value > 0 else "-inf"
    return value

"""What is asked of a firmware, checked once."""

from dataclasses import dataclass, fields, replace
from fractions import Fraction
from re import fullmatch
from typing import Literal

from zoh import checks
from zoh.analysis.tabled.verify import TableVerified
from zoh.analysis.verify import Verified
from zoh.errors import SpecError
from zoh.firmware.book import IO_BITS, Features, Format
from zoh.firmware.lines import NUMBERS, Number
from zoh.spec import Requirements

Design = Verified | TableVerified  # verified on a model, or on a table
WINDUPS = ("auto", "conditional", "back_calculation", "tracking", "none")
REALISATIONS = ("auto", "pid", "cascade", "delta")
_ROUNDED = (
    1e-5  # of a bound: a design that meets one with nothing to spare still is one when rounded
)
_AT_LEAST = ("pm_deg", "gain_margin_db", "delay_margin", "bandwidth", "effort_min")
KEYWORDS = (
    "auto break case char const continue default do double else enum extern float for goto if "
    "inline int long register restrict return short signed sizeof static struct switch typedef "
    "union unsigned void volatile while class new delete this template namespace using operator "
    "private public protected try catch throw true false bool"
).split()
HEADERS = (  # a header of this name beside the source would be found in the place of C's
    "assert complex ctype errno fenv inttypes iso646 limits locale math setjmp signal stdalign "
    "stdarg stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time "
    "uchar wchar wctype main arduino"  # and the boards' own
).split()
TAKEN = frozenset({*KEYWORDS, *HEADERS})


@dataclass(frozen=True, slots=True, kw_only=True)
class Asked:
    """A request whose every value is in range."""

    verified: Design
    name: str
    number: Number | Literal["auto"]
    u_min: float | None
    u_max: float | None
    rate: float | None
    anti_windup: str
    setpoint_weight: float
    derivative_weight: float
    y_range: tuple[float, float] | None
    u_range: tuple[float, float] | None
    realisation: str

    @property
    def weighted(self) -> str:
        """Return the name of a weight of the reference that is not 1; empty where none is."""
        if self.setpoint_weight != 1:
            return "setpoint_weight"
        return "derivative_weight" if self.derivative_weight != 1 else ""

    @property
    def needs_parallel(self) -> str:
        """Return the name of what only the parallel form has; empty where nothing is."""
        if self.weighted:
            return self.weighted
        return "anti_windup" if self.anti_windup in ("conditional", "back_calculation") else ""

    @property
    def in_sections(self) -> str:
        """Return what of ``needs_parallel`` sections take."""
        if self.needs_parallel == "anti_windup":
            return "must be tracking or none for a controller in sections"
        return "must be 1 for a controller in sections"

    @property
    def eased(self) -> Requirements:
        """Return the requirements, their bounds let out by what rounding takes; 0 stays 0."""
        bounds = {}
        for field in fields(Requirements):
            bound = getattr(self.verified.requirements, field.name)
            if bound is not None:
                out = -1 if field.name in _AT_LEAST else 1
                bounds[field.name] = bound + out * _ROUNDED * abs(bound)
        return replace(self.verified.requirements, **bounds)

    def format(self, number: Number) -> Format:
        """Return the format with its units; raise SpecError where a range is missing."""
        if number not in IO_BITS:
            return Format(number=number)
        steps = 1 << IO_BITS[number] - 1
        units = []
        for name, span in (("y_range", self.y_range), ("u_range", self._u_span)):
            if span is None:
                raise SpecError(
                    name, f"must be given for {number}, whose numbers are whole", None,
                    f"{name}=(least, most) in physical units",
                )  # fmt: skip
            units.append(Fraction(max(abs(span[0]), abs(span[1]))) / steps)
        return Format(number=number, y_unit=units[0], u_unit=units[1])

    @property
    def _u_span(self) -> tuple[float, float] | None:
        if self.u_range is not None or self.u_min is None or self.u_max is None:
            return self.u_range
        return self.u_min, self.u_max

    def features(self, form: Format, *, integral: bool, sections: bool, back: Fraction) -> Features:
        """Return what is built in: whole numbers always have limits, those of their format."""
        low, high = (None if b is None else Fraction(b) for b in (self.u_min, self.u_max))
        if form.whole:
            low = form.least * form.u_unit if low is None else low
            high = form.most * form.u_unit if high is None else high
        change = None
        if self.rate is not None:
            change = Fraction(self.rate) * Fraction(self.verified.dt)
        limited = not (low is high is change is None)
        how = self.anti_windup
        if how == "auto":
            how = "conditional" if integral else "tracking" if sections else "none"
        if not limited or not (integral or sections):
            how = "none"
        return Features(
            u_min=low, u_max=high, change=change, anti_windup=how,
            r_weight=Fraction(self.setpoint_weight), d_weight=Fraction(self.derivative_weight),
            back=back if how == "back_calculation" else Fraction(1),
        )  # fmt: skip


def _weight(name: str, value: object, verified: Verified | TableVerified) -> float:
    """Return a weight of the reference, the design's own where none is given."""
    own = getattr(verified, name) if isinstance(verified, Verified) else 1.0
    return _share(name, own if value is None else value)


def asked(
    verified: object, *, name: object, number: object, u_min: object, u_max: object,
    rate: object, anti_windup: object, setpoint_weight: object, derivative_weight: object,
    y_range: object, u_range: object, realisation: object,
) -> Asked:  # fmt: skip
    """Return the request, checked; raise SpecError."""
    if not isinstance(verified, Verified | TableVerified):
        raise SpecError(
            "verified", "must be a verified design", verified, "zoh.pid(...) or zoh.verify(...)"
        )
    low = None if u_min is None else checks.number("u_min", u_min)
    high = None if u_max is None else checks.number("u_max", u_max)
    if low is not None and high is not None and not low < high:
        raise SpecError("u_max", f"must be above u_min = {low:g}", high, "swap the two")
    return Asked(
        verified=verified,
        name=_identifier(name),
        number=_number(number),
        u_min=low,
        u_max=high,
        rate=None if rate is None else checks.positive("rate", rate, "give units of u a second"),
        anti_windup=_one_of("anti_windup", anti_windup, WINDUPS),
        setpoint_weight=_weight("setpoint_weight", setpoint_weight, verified),
        derivative_weight=_weight("derivative_weight", derivative_weight, verified),
        y_range=_range("y_range", y_range),
        u_range=_range("u_range", u_range),
        realisation=_one_of("realisation", realisation, REALISATIONS),
    )


def _identifier(name: object) -> str:
    text = checks.text("name", name)
    taken = text in TAKEN or text.lower() in HEADERS  # in file names capitals may not count
    if not fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,30}", text) or taken:
        raise SpecError(
            "name",
            "must be a C identifier of 31 characters or fewer, no word or header of C's",
            name,
            'such as "arm_pid"',
        )
    return text


def _number(value: object) -> Number | Literal["auto"]:
    name = _one_of("number", value, ("auto", *NUMBERS))
    return next((n for n in NUMBERS if n == name), "auto")


def _one_of(name: str, value: object, known: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in known:
        raise SpecError(name, f"must be one of {', '.join(known)}", value, "choose one of these")
    return value


def _share(name: str, value: object) -> float:
    share = checks.number(name, value)
    if not 0 <= share <= 1:
        raise SpecError(name, "must be in [0, 1]", value, "0 leaves the reference out, 1 in")
    return share


def _range(name: str, value: object) -> tuple[float, float] | None:
    if value is None:
        return None
    way_out = "give (least, most) in physical units"
    ends = checks.sequence(name, value, way_out)
    if len(ends) != 2:
        raise SpecError(name, "must have two ends", value, way_out)
    low, high = (checks.number(f"{name}[{i}]", end, way_out) for i, end in enumerate(ends))
    if not low < high:
        raise SpecError(name, "must rise", value, way_out)
    return low, high

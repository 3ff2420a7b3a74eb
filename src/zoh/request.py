"""What may be asked of a law: its parameters, its options, and what is allowed by name."""

from collections.abc import Callable, Iterable, Mapping
from math import inf

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.weights import WEIGHTS

Progress = Callable[[str], None]  # called with a sentence while something is searched

LAWS: Mapping[str, tuple[str, ...]] = {
    "p": ("wc", "pm_deg"),
    "pi": ("wc", "pm_deg"),
    "pd": ("wc", "pm_deg"),
    "pid": ("wc", "pm_deg", "ki"),
    "lag": ("wc", "pm_deg", "dc_gain"),
    "textbook_lag": ("wc", "dc_gain"),
    "lead": ("wc", "pm_deg", "dc_gain"),
    "leadlag": ("wc", "pm_deg", "dc_gain"),
}
"""Every law and the parameters it takes."""

OPTIONS: Mapping[str, tuple[str, ...]] = {
    "p": ("setpoint_weight",),
    "pi": ("setpoint_weight",),
    "pd": ("filter_pole", *WEIGHTS),
    "pid": ("filter_pole", "ti_td", "largest_ki_ms", "least_iae_ms", *WEIGHTS),
    "textbook_lag": ("pm_deg",),
    "leadlag": ("lag_corner", "lag_ratio"),
}
"""What a law takes besides; one of the PID's ``SPARE`` stands for its ki."""

UNDER_MS = ("largest_ki_ms", "least_iae_ms")
SPARE = ("ki", "ti_td", *UNDER_MS)
AUTO = "auto"
OF_AUTO = ("wc", "pm_deg")  # the parameters that every law understands

NEGATIVE_GAINS = "negative_gains"
UNSTABLE_CONTROLLERS = "unstable_controllers"
CANCELLED_UNSTABLE_MODES = "cancelled_unstable_modes"
ALLOWABLE: Mapping[str, str] = {
    NEGATIVE_GAINS: "gains and zeros of any sign",
    UNSTABLE_CONTROLLERS: "a controller with poles outside the unit circle",
    CANCELLED_UNSTABLE_MODES: "a plant without the unstable modes that its num and den share",
}
"""What is refused unless ``allow`` names it."""

_USUAL = {
    "largest_ki_ms": "1.4 to 2",
    "least_iae_ms": "1.4 to 2",
    "lag_ratio": "3 to 20",
}
_MOST_MS = 1e6  # a loop of this Ms is unstable after a change of its gain in the sixth digit
_OF_ANY_SIGN = {
    "ki": NEGATIVE_GAINS, "dc_gain": NEGATIVE_GAINS, "filter_pole": UNSTABLE_CONTROLLERS,
}  # fmt: skip


def checked(
    law: object, given: object, allow: frozenset[str] = frozenset()
) -> dict[str, float]:  # fmt: skip
    """Return the parameters given (None is not given); raise SpecError unless they fit the law.

    >>> checked("pid", {"wc": 2.0, "pm_deg": 50, "ki": None})
    {'wc': 2.0, 'pm_deg': 50.0}
    >>> checked("pid", {"wc": 2.0, "ki": -1.0})
    Traceback (most recent call last):
    zoh.errors.SpecError: ki must be above 0, got -1.0: allow=["negative_gains"] permits it
    """
    if not isinstance(law, str) or (law not in LAWS and law != AUTO):
        names = ", ".join((*LAWS, AUTO))
        raise SpecError("law", f"must be one of {names}", law, "choose one of these")
    if not isinstance(given, Mapping):
        raise SpecError("given", "must name the law's parameters", given, '{"wc": 1, "pm_deg": 50}')
    takes = LAWS.get(law, OF_AUTO) + OPTIONS.get(law, ())
    for name, value in given.items():
        if name not in takes:
            bound = f"is no parameter of {law} ({', '.join(takes)})"
            owner = next((k for k in LAWS if name in LAWS[k] + OPTIONS.get(k, ())), None)
            way_out = (
                f'name the law, such as "{owner}"' if law == AUTO and owner else "leave it out"
            )
            raise SpecError(str(name), bound, value, way_out)
    parameters = {k: _value(k, v, allow) for k, v in given.items() if v is not None}
    spare = [name for name in SPARE if name in parameters]
    if len(spare) > 1:
        bound = f"must not be given beside {spare[0]}"
        raise SpecError(spare[1], bound, parameters[spare[1]], "one closes the PID's freedom")
    return parameters


def _value(name: str, value: object, allow: frozenset[str]) -> float:
    """Return one parameter, checked."""
    if name in WEIGHTS:
        return checks.not_negative(name, value, "0 to 1 is usual")
    word = _OF_ANY_SIGN.get(name)
    found = checks.number(name, value, "give a number above zero")
    if word is not None and found < 0 and word not in allow:
        raise SpecError(name, "must be above 0", value, f'allow=["{word}"] permits it')
    if found == 0 or (found < 0 and word is None):
        checks.positive(name, value)
    if name in _USUAL and found <= 1:
        raise SpecError(name, "must be above 1", found, f"{_USUAL[name]} is usual")
    if name in UNDER_MS and found > _MOST_MS:
        raise SpecError(name, f"must be at most {_MOST_MS:g}", found, f"{_USUAL[name]} is usual")
    return found


def allowed(allow: object) -> frozenset[str]:
    """Return what is allowed; raise SpecError unless each word is one of ``ALLOWABLE``.

    >>> sorted(allowed(["negative_gains"]))
    ['negative_gains']
    """
    if isinstance(allow, str | Mapping) or not isinstance(allow, Iterable):
        raise _not_allowed("must be a list of words", allow)
    try:
        words = list(allow)
    except TypeError:  # an array of no dimension
        raise _not_allowed("must be a list of words", allow) from None
    for word in words:
        if not isinstance(word, str) or word not in ALLOWABLE:
            raise _not_allowed("must hold words that are known", word)
    return frozenset(words)


def _not_allowed(bound: str, value: object) -> SpecError:
    return SpecError("allow", bound, value, f"a list of {', '.join(ALLOWABLE)}")


def left_open(law: str, parameters: Mapping[str, float]) -> list[str]:
    """Return the parameters that were left open; a P has one of two, a PID one of ``SPARE``."""
    if law == "p" and any(name in parameters for name in OF_AUTO):
        return []
    closed = not parameters.keys().isdisjoint(SPARE)
    takes = ("law",) if law == AUTO else LAWS[law]
    return [name for name in takes if name not in parameters and not (name == "ki" and closed)]


def is_closed(law: str, parameters: Mapping[str, float]) -> bool:
    """Return whether a crossover is given and all that the law needs there; a P needs no margin.

    >>> is_closed("pid", {"wc": 2.0, "pm_deg": 50.0, "ti_td": 4.0}), is_closed("p", {"pm_deg": 50})
    (True, False)
    """
    return law in LAWS and "wc" in parameters and not left_open(law, parameters)


def check_whole(law: str, parameters: Mapping[str, float], why: str) -> None:
    """Raise SpecError where something of the request, its margin included, is left open."""
    left = [*left_open(law, parameters), *(k for k in OF_AUTO if k not in parameters)]
    if left:
        takes = ", ".join(LAWS.get(law, OF_AUTO))
        raise SpecError(left[0], f"must be given {why}", None, f"{law} takes {takes}")


def check_choosable(law: str, name: str) -> None:
    """Refuse to choose where the law is a rule that has nothing to choose by."""
    if law == "textbook_lag":
        takes = ", ".join(LAWS[law])
        raise SpecError(name, f"must be given for {law}", None, f"{law} takes {takes}")


def bounded_ms(parameters: Mapping[str, float]) -> float:
    """Return the bound on Ms that a search of the spare gain is made under; inf where none is."""
    return min([parameters[k] for k in UNDER_MS if k in parameters], default=inf)

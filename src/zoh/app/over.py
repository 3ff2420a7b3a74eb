"""What a sweep runs over, as it is written on the command line: KEY=FROM:TO:N and its like.

wc=1:3:21          a grid of 21 values, both ends among them; wc=0.1:10:21:log spaced so
wc=1,2,5           these values
plant.gain=2:3     an interval, for --sample (uniform) and --corners (its ends)
plant.gain=2:3:log an interval, uniform in the logarithm
plant.gain=2.5~0.1 normal, mean and standard deviation, for --sample
"""

from collections.abc import Sequence

import numpy as np

from zoh import checks
from zoh.batch.space import Grid, Random, Space, corners
from zoh.batch.spread import LogUniform, Normal, Spread, Uniform
from zoh.errors import SpecError

_LOG = "log"
_WAYS = "FROM:TO:N, FROM:TO:N:log or V1,V2,..."
_SPREADS = "FROM:TO, FROM:TO:log or MEAN~SD"


def read_over(
    texts: Sequence[str], *, sample: int | None, seed: int | None, latin: bool, ends: bool
) -> Space:  # fmt: skip
    """Return the grid, the corners or the random sample that the texts say.

    >>> read_over(["wc=1:2:3", "dt=0.1"], sample=None, seed=None, latin=False, ends=False).shape
    (3, 1)
    """
    given = dict(_split(text) for text in texts)
    if len(given) < len(texts):
        raise SpecError("--over", "must name a key once", " ".join(texts), "leave one out")
    if sample is not None:
        if ends:
            raise SpecError("--corners", "must not stand beside --sample", sample, "choose one")
        spreads = {key: _spread(key, said) for key, said in given.items()}
        return Random(spreads=spreads, count=sample, seed=seed or 0, latin=latin)
    for option, value in (("--latin", latin or None), ("--seed", seed)):
        if value is not None:
            way_out = "say how many: --sample N"
            raise SpecError(option, "must stand beside --sample", value, way_out)
    if ends:
        return corners({key: _spread(key, said) for key, said in given.items()})
    return Grid(axes={key: _values(key, said) for key, said in given.items()})


def _split(text: str) -> tuple[str, str]:
    key, equals, said = text.partition("=")
    if not (equals and key and said):
        raise SpecError("--over", "must be KEY=" + _WAYS, text, "such as wc=1:3:21")
    return key.strip(), said.strip()


def _values(key: str, said: str) -> Sequence[float]:
    parts = said.split(":")
    if len(parts) == 1:
        return [_number(key, part) for part in said.split(",")]
    if len(parts) not in (3, 4) or (len(parts) == 4 and parts[3] != _LOG):
        way_out = "an interval without a number of values is for --sample or --corners"
        raise SpecError(f"--over {key}", f"must be {_WAYS}", said, way_out)
    low, high = _number(key, parts[0]), _number(key, parts[1])
    count = checks.whole(f"--over {key}", _number(key, parts[2]), 1, "the number of values")
    if len(parts) == 3:
        return [float(x) for x in np.linspace(low, high, count)]
    for end in (low, high):
        checks.positive(f"--over {key}", end, "a logarithm is of numbers above 0")
    return [float(x) for x in np.geomspace(low, high, count)]


def _spread(key: str, said: str) -> Spread:
    if "~" in said:
        mean, _, sd = said.partition("~")
        return Normal(mean=_number(key, mean), sd=_number(key, sd))
    parts = said.split(":")
    if len(parts) == 2:
        return Uniform(low=_number(key, parts[0]), high=_number(key, parts[1]))
    if len(parts) == 3 and parts[2] == _LOG:
        return LogUniform(low=_number(key, parts[0]), high=_number(key, parts[1]))
    way_out = "a sample has no number of values for a key; --sample N says how many loops"
    raise SpecError(f"--over {key}", f"must be {_SPREADS}", said, way_out)


def _number(key: str, text: str) -> float:
    try:
        return checks.number(f"--over {key}", float(text))
    except ValueError:
        raise SpecError(f"--over {key}", f"must be {_WAYS}", text, "numbers") from None

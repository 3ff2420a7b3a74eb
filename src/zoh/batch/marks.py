"""What two sweeps must share to be one: all that the bits of a store depend on but the machine."""

import json
from collections.abc import Mapping, Sequence
from hashlib import sha256
from itertools import takewhile
from typing import Any

import numpy as np

from zoh.batch import bounds
from zoh.batch.blocks import Plan, versions
from zoh.batch.space import Grid, Random, Space
from zoh.lti.systems import Plant
from zoh.spec import Requirements

MARK = "zoh"  # the attribute of a store that says the rest of it
_LONGEST = 60
_BEFORE = 20  # characters that are shown before two texts differ


def mark(plan: Plan, keep: Sequence[str], requirements: Requirements) -> dict[str, Any]:
    """Return what a store is known by, besides what ``described`` says."""
    job = plan.job
    digits = repr(job.plant.exact) if isinstance(job.plant, Plant) else ""
    return {
        "arithmetic": plan.arithmetic, "versions": versions(plan.arithmetic),
        "varying": list(job.varying), "over": _said(plan.space), "loops": plan.loops,
        "requirements": repr(bounds.asked(requirements)), "keep": list(keep), "block": plan.block,
        "plant_digits": sha256(digits.encode()).hexdigest(),
    }  # fmt: skip


def difference(theirs: Mapping[str, Any], ours: Mapping[str, Any]) -> str:
    """Return what differs first between two stores' attributes, in words, "" where nothing does.

    >>> difference({"law": "pi", "zoh": {"block": 8}}, {"law": "pi", "zoh": {"block": 9}})
    'its block is 8, not 9'
    """
    old, new = ({**attributes, **attributes[MARK]} for attributes in (theirs, ours))
    for key in (k for k in {**new, **old} if k != MARK):
        if old.get(key) != new.get(key):
            before, now = _apart(old.get(key), new.get(key))
            return f"its {key} is {before}, not {now}"
    return ""


def _apart(old: object, new: object) -> list[str]:
    """Return both whole where they are short, or from a little before they differ.

    >>> _apart("numpy 2.1.0", "numpy 2.2.0")
    ['numpy 2.1.0', 'numpy 2.2.0']
    >>> _apart("a" * 50 + "the quick brown fox jumps", "a" * 50 + "the quick brown fox jumped")
    ['... brown fox jumps', '... brown fox jumped']
    """
    texts = [value if isinstance(value, str) else json.dumps(value) for value in (old, new)]
    if all(len(text) <= _LONGEST for text in texts):
        return texts
    alike = takewhile(lambda pair: pair[0] == pair[1], zip(*texts, strict=False))
    start = max(0, sum(1 for _ in alike) - _BEFORE)
    cut = [("..." if start else "") + text[start:] for text in texts]
    return [text if len(text) <= _LONGEST else text[:_LONGEST] + "..." for text in cut]


def _said(space: Space) -> str:
    """Return what identifies the loops of a space."""
    if isinstance(space, Random):
        return repr(space)
    columns = space.axes if isinstance(space, Grid) else space.values
    found = sha256()
    for key, column in columns.items():
        found.update(key.encode())
        found.update(np.ascontiguousarray(column).tobytes())
    values = ", ".join(f"{len(column)} of {key}" for key, column in columns.items())
    return f"{type(space).__name__} of {values}, SHA-256 {found.hexdigest()}"

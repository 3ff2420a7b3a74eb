"""A sweep with its labels: an xarray.Dataset with units, long names, and the meaning of each code.

Attributes follow the CF conventions (cfconventions.org): ``units``, ``long_name``, and for the
reasons ``flag_values`` and ``flag_meanings``.
"""

from typing import TYPE_CHECKING, Any

import numpy as np

import zoh
from zoh.batch.extras import needed
from zoh.batch.figures import BY_NAME
from zoh.batch.job import Job
from zoh.batch.reason import Reason
from zoh.batch.result import Sweep
from zoh.batch.space import Grid

if TYPE_CHECKING:
    from xarray import Dataset

LOOP = "loop"
"""The dimension of what is no grid."""

_UNITS = {
    "dt": "s", "compute_delay": "s", "dead_time": "s", "wc": "rad/s", "pm_deg": "deg",
    "filter_pole": "rad/s", "w0": "rad/s", "wp": "rad/s", "lag_corner": "rad/s",
}  # fmt: skip
_NAMES = {
    "dt": "sample time", "compute_delay": "delay from sampling to output",
    "dead_time": "dead time of the plant", "wc": "crossover asked for",
    "pm_deg": "phase margin asked for", "ki": "integral gain", "kp": "proportional gain",
    "kd": "derivative gain", "dc_gain": "gain at w = 0",
}  # fmt: skip


def attributes(name: str) -> dict[str, Any]:
    """Return the attributes of a column, whichever it is.

    >>> attributes("ms")
    {'long_name': 'peak of the sensitivity, Ms', 'units': '1'}
    """
    if name in BY_NAME:
        return {"long_name": BY_NAME[name].long_name, "units": BY_NAME[name].unit}
    if name == "stable":
        return {"long_name": "whether the closed loop is proved to be stable"}
    if name == "reason":
        return {
            "long_name": "why a loop has figures or has none",
            "flag_values": [int(reason) for reason in Reason],
            "flag_meanings": " ".join(reason.name.lower() for reason in Reason),
        }
    short = name.removeprefix("gains.")
    units = {"units": _UNITS[short]} if short in _UNITS else {}
    return {"long_name": _NAMES.get(short, name), **units}


def described(job: Job) -> dict[str, str]:
    """Return what a sweep is of, for the attributes of a file."""
    return {
        "source": f"zoh {zoh.__version__}", "plant": repr(job.plant), "law": job.law,
        "asked": repr(dict(job.asked)), "dt": repr(job.dt),
        "compute_delay": repr(job.compute_delay), "reference": repr(job.reference),
    }  # fmt: skip


def dataset(sweep: Sweep) -> "Dataset":
    """Return the sweep as a Dataset: a grid has an axis for each key, all else the axis "loop"."""
    xarray = needed("xarray", "a labelled result")
    space = sweep.space
    if isinstance(space, Grid):
        dims, shape = space.keys, space.shape
        coords = {key: (key, np.array(axis), attributes(key)) for key, axis in space.axes.items()}
    else:
        dims, shape = (LOOP,), (len(sweep),)
        coords = {key: (LOOP, column, attributes(key)) for key, column in sweep.columns.items()}
    variables = {
        name: (dims, column.reshape(shape), attributes(name))
        for name, column in sweep.results.items()
    }
    about = {**described(sweep.job), "computed_by": sweep.computed_by}
    found: Dataset = xarray.Dataset(variables, coords=coords, attrs=about)
    return found

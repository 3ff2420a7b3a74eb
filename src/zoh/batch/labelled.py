"""A sweep with its labels: an xarray.Dataset with units, long names, and the meaning of each code.

Attributes follow the CF conventions (cfconventions.org): ``units``, ``long_name``, and for the
reasons ``flag_values`` and ``flag_meanings``.
"""

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

import zoh
from zoh.batch.extras import needed
from zoh.batch.job import Job
from zoh.batch.reason import Reason
from zoh.batch.result import Sweep
from zoh.batch.sources import Source
from zoh.batch.space import Grid
from zoh.batch.units import unit_and_name

if TYPE_CHECKING:
    from xarray import Dataset

LOOP = "loop"
"""The dimension of what is no grid."""


def attributes(name: str, plant: Source) -> dict[str, Any]:
    """Return the attributes of a column, whichever it is.

    >>> from zoh.lti.systems import Plant
    >>> attributes("ms", Plant(num=[1], den=[1, 0]))
    {'long_name': 'peak of the sensitivity, Ms', 'units': '1'}
    """
    unit, long_name = unit_and_name(name, plant)
    found: dict[str, Any] = {"long_name": long_name, "units": unit}
    if name == "reason":
        found["flag_values"] = [int(reason) for reason in Reason]
        found["flag_meanings"] = " ".join(reason.name.lower() for reason in Reason)
    return found


def described(job: Job) -> dict[str, str]:
    """Return what a sweep is of, for the attributes of a file; controller and sections as JSON."""
    given = job.controller
    controller = None if given is None else {"num": given.num, "den": given.den, "dt": given.dt}
    sections = [{name: float(x) for name, x in asdict(s).items()} for s in job.sections]
    return {
        "source": f"zoh {zoh.__version__}", "plant": repr(job.plant), "law": job.law,
        "asked": repr(dict(job.asked)), "dt": repr(job.dt),
        "compute_delay": repr(job.compute_delay), "reference": repr(job.reference),
        "controller": json.dumps(controller), "sections": json.dumps(sections),
    }  # fmt: skip


def dataset(sweep: Sweep) -> "Dataset":
    """Return the sweep as a Dataset: a grid has an axis for each key, all else the axis "loop"."""
    xarray = needed("xarray", "a labelled result")
    space, plant = sweep.space, sweep.job.plant
    if isinstance(space, Grid):
        dims, shape = space.keys, space.shape
        coords = {
            key: (key, np.array(axis), attributes(key, plant)) for key, axis in space.axes.items()
        }
    else:
        dims, shape = (LOOP,), (len(sweep),)
        coords = {
            key: (LOOP, column, attributes(key, plant)) for key, column in sweep.columns.items()
        }
    variables = {
        name: (dims, column.reshape(shape), attributes(name, plant))
        for name, column in sweep.results.items()
    }
    about = {**described(sweep.job), "computed_by": sweep.computed_by}
    found: Dataset = xarray.Dataset(variables, coords=coords, attrs=about)
    return found

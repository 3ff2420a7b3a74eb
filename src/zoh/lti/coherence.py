"""How far an averaged frequency response can be trusted, from its coherence."""

from math import sqrt

import numpy as np
import numpy.typing as npt

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.curve import Array


def random_error(coherence: npt.ArrayLike, averages: int) -> Array:
    """Return the relative 1 sigma of an averaged response from its coherence gamma^2.

        sigma = sqrt(1 - gamma^2) / (|gamma| sqrt(2 averages))

    Source: J. S. Bendat and A. G. Piersol, Random Data, the chapter on random errors of
    frequency response estimates (independent averages, noise on the output).

    >>> random_error([0.5], averages=50)
    array([0.1])
    """
    count = checks.whole("averages", averages, 1, "count the independent averages")
    gamma2 = np.atleast_1d(checks.frequencies("coherence", coherence))
    wrong = gamma2[(gamma2 <= 0) | (gamma2 > 1)]
    if wrong.size:
        raise SpecError("coherence", "must be inside (0, 1]", float(wrong[0]), "gamma squared")
    # root by root, no count of averages is too large
    return np.asarray(np.sqrt(1 - gamma2) / np.sqrt(2 * gamma2) / sqrt(count))

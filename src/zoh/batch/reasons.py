"""Why a loop of a batch has no figures, or not all of them."""

from enum import IntEnum


class Reason(IntEnum):
    """What became of one loop; every figure that is missing has one of these beside it.

    Codes are fixed: they are written to files.
    """

    OK = 0
    INFEASIBLE = 1  # the law cannot give the phase and gain needed
    UNSTABLE = 2  # the closed loop is unstable
    OFF_TARGET = 3  # stable, but another crossover has the smaller margin
    MISSES = 4  # stable and on target, but misses a requirement
    MALFORMED = 5  # the request is none: wc not below Nyquist's frequency, dt not positive
    NOT_PROVED = 6  # stability is not decided

    @property
    def words(self) -> str:
        """Return the reason in words.

        >>> Reason.OFF_TARGET.words
        'another crossover has a smaller margin'
        """
        return _WORDS[self]


_WORDS = {
    Reason.OK: "met",
    Reason.INFEASIBLE: "the law cannot be solved here",
    Reason.UNSTABLE: "the closed loop is unstable",
    Reason.OFF_TARGET: "another crossover has a smaller margin",
    Reason.MISSES: "a requirement is missed",
    Reason.MALFORMED: "the request is malformed",
    Reason.NOT_PROVED: "stability is not proved",
}

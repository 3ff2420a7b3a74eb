"""Why a loop of a batch has figures, or why it has none: one small number for each loop."""

from enum import IntEnum


class Reason(IntEnum):
    """What became of one loop; ``words`` is the sentence that people read.

    OK              designed, proved to be stable, and as it was asked for
    INFEASIBLE      the law cannot do at this crossover what was asked
    UNSTABLE        the law has gains, but its loop is unstable
    NOT_PROVED      no proof decides whether the loop is stable
    OFF_TARGET      stable, but another crossover of the loop has the smaller margin
    BEYOND_NYQUIST  the crossover asked for is not below the Nyquist frequency
    MALFORMED       a value is out of its range, or the gains are beyond a float

    A loop that is not OK or OFF_TARGET has no figures, all of them are NaN; its gains are there
    where the law has some. In a loop with figures a NaN is what does not exist: a frequency
    where the loop crosses nothing, the time of a peak that is never reached.

    >>> Reason(2).words
    'the loop is unstable'
    """

    OK = 0
    INFEASIBLE = 1
    UNSTABLE = 2
    NOT_PROVED = 3
    OFF_TARGET = 4
    BEYOND_NYQUIST = 5
    MALFORMED = 6

    @property
    def words(self) -> str:
        """Return the reason as a sentence."""
        return _WORDS[self]

    @property
    def has_figures(self) -> bool:
        """Return whether the loop is stable, so that its figures exist."""
        return self in (Reason.OK, Reason.OFF_TARGET)


_WORDS = {
    Reason.OK: "designed and verified",
    Reason.INFEASIBLE: "the law cannot do what is asked at this crossover",
    Reason.UNSTABLE: "the loop is unstable",
    Reason.NOT_PROVED: "no proof decides whether the loop is stable",
    Reason.OFF_TARGET: "stable, but another crossover has the smaller margin",
    Reason.BEYOND_NYQUIST: "the crossover is not below the Nyquist frequency",
    Reason.MALFORMED: "a value is out of its range or beyond a float",
}

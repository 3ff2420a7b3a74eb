"""What both fast arithmetics of a batch hold to: when floats do not decide, what no longer counts.

One list, so that the two leave the same loops to the single design and stop at the same place.
"""

from math import log

import numpy as np

PIVOT = 1e-11  # of its terms: an element of Routh's scheme whose sign rounding may have made
DOUBLE = 1e-10  # of its terms: a polynomial's value at an extreme that may be 0
UNITY = 1e-11  # |L| this near to 1 at an end of the axis is for exact arithmetic to decide
ROOM = 1e-11  # rad from the end of what a law can give: within rounding of it
SAME_TURN = 1e-12  # rad; a P turns the phase by nothing, but for rounding
RESONANT = 1e-3  # of its terms: the plant this small at the crossover lacks digits of its phase
ON_TARGET = 1e-9  # of the crossover, and deg of the margin: what a design promises
ON_IT_DEG = 1e-12  # a margin this small is 0: a few roundings of the angle
SHARP = 1e3  # Ms above which rounding of a plant of order 3 may be a billionth of the response
DROP = 10.0**-0.3  # 3 dB below, squared

GRID = np.geomspace(1e-2, 1e4, 16)  # of q, where something is looked for first; 1 is one of it

SMALL = 0.5  # the norm of A dt up to which the exponential's series is taken as it stands
SERIES = 18  # its terms: 0.5^18/18! is 6e-22
SLOW, EULERS = 1.5, 40  # the reach of the series at z = -1, and its terms: (1.5/pi)^40 is 1e-13
HELD = 1e-12  # by so much the gain at rest of what is held, and a final value, may be off
REACH, TAYLOR = 20.0, 72  # |A| dt up to which the series between samples keeps its digits; terms
CUBIC = 2.0  # |A| dt up to which a cubic tells about how high a crest is
BERNSTEIN = 24  # degree that tells how often a slope turns: 1.2^24 is 1e-22 of 24!
FLAT = 1e-13  # of y: a slope this small over a whole piece is rounding

APART = 1e-4  # of a pole: three digits of it say how it turns
LOST = 2e-9  # of the final value: what is left of a mode no longer says where to look
QUIET = log(1e10)  # the slowest mode is followed until it has fallen so far
SHOWN = 1e6  # samples that the single design looks at: of what lives longer it asks for a bound
REST, GONE = log(1e4), 36.0  # decay of the slowest mode at its rest; of a mode that it leaves out
TURN = 0.25  # rad that a mode turns at most between two samples that are looked at
BAND, NEAR = 0.02, 0.9  # a response has settled in its band; alone and in this part of it it stays
CREST = 0.98  # of the band: between samples at a long stride it may be left
BELOW = 0.02  # of the highest sample: how far below it a crest's own may be, at a long stride
NOTHING = 1e-10  # an overshoot below this part of the final value is rounding
FAINT = 1e-9  # a final value below this is lost in what is left of the modes, QUIET or not
ROUGH = 1 << 16  # samples of a response whose slope leaps at each of them: no stride is longer
LEVELS = 40  # doublings of the stride that a loop is followed for
MOST, FAR = 4096, 1 << 20  # samples at one stride, by arrays and by the compiled loop

"""Every array that one loop needs: the plant, the law, their motion, and room to work in."""

from typing import NamedTuple

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled.layout import Layout
from zoh.batch.tolerances import BERNSTEIN, EULERS, LEVELS, SERIES, TAYLOR

ORDER = 6  # of a plant
SIZE = 15  # of Z: a plant of order 6, four inputs under way, a controller of order 3, a one
MOST = 32  # places of a polynomial
WIDE, LANES = 16, 8  # numbers of Z, and how many are moved at once; the rest are 0
PAST = LANES  # columns of a block in front of its first sample; two of them are looked at
BLOCK = 32  # samples between two looks at whether a loop is done
ROOM = PAST + BLOCK + LANES  # columns of a block: it ends with the next one's first
DOUBLINGS = 3  # of the motion by one sample: by ``LANES`` samples
SEEN, KEPT = 12, 4  # what is seen of a step response, and the states that are kept of it
SIDES, NOTES = 3, 7  # quotients side by side, and rows of what is known of them
WHOLE, LATE, PART = range(3)  # times that a plant is moved by: a sample, its end, a piece of it


class Plant(NamedTuple):
    """What the hold makes: see ``zoh.batch.arrays.held.Held``; the first places of longer arrays.

    a, b     the plant in samples, then in the unit;  markov in the unit, h in samples
    delta, enters   by what the state moves, and an input moves it, in each of three times
    numbers  samples of the unit, reach, how far off the gain at rest has come out, terms
    """

    top: Array
    bottom: Array
    delta: Array
    enters: Array
    rows: Array
    markov: Array
    a: Array
    b: Array
    matrix: Array
    other: Array
    fl: Array
    numbers: Array


class Law(NamedTuple):
    """A controller: num, den in p; x moves by moves x + enters e, u = residues x + direct e.

    leads    what e moves by, x moves by times this, too; it is x as the reference steps
    numbers  direct, room, and the gains
    """

    num: Array
    den: Array
    moves: Array
    enters: Array
    leads: Array
    residues: Array
    numbers: Array


class Motion(NamedTuple):
    """Rows on Z: output, effort, what they move by in a sample; Z at first; then the modes.

    numbers   final, at_rest;  re, im  z of each mode;  room  of ``modes``
    wr, wi    the weights of its share, a mode a column;  shares  its share of output and effort
    turn      |log z|;  creeping  1.0 for the slowest mode, if it does not swing
    """

    output: Array
    effort: Array
    output_moves: Array
    effort_moves: Array
    start: Array
    numbers: Array
    re: Array
    im: Array
    room: Array
    wr: Array
    wi: Array
    shares: Array
    turn: Array
    creeping: Array


class Pieces(NamedTuple):
    """The parts of every sample: rows on Z, and their ends as parts of a sample.

    derivatives, series, bernstein  y's in one; y by Taylor's coefficients, its slope by Bernstein's
    bends  of each state and input its weight, its rest and its row: see ``turns``
    """

    y0: Array
    y1: Array
    slope0: Array
    slope1: Array
    state: Array
    input: Array
    ends: Array
    series: Array
    derivatives: Array
    bernstein: Array
    bends: Array


class Lines(NamedTuple):
    """Polynomials: num and den of the loop in u; squares of sizes on the axis; room.

    work  of ``positive_roots``;  grid  values at the points of a grid
    parts  in q: num and den of even powers, then of odd ones;  some, rest  room for one
    over, under, sides  of ``quotients``
    """

    num: Array
    den: Array
    nn: Array
    dd: Array
    aa: Array
    bb: Array
    some: Array
    rest: Array
    roots: Array
    edges: Array
    parts: Array
    work: Array
    grid: Array
    over: Array
    under: Array
    sides: Array


class Track(NamedTuple):
    """A step response on its way; see ``track``.

    block   Z by columns, its first number y, its last one 1; then the rows of what is seen
    states  those that are kept
    ladder  by what Z moves in 1, 2, 4, ... samples, by columns: [level, j, i] is s_ij
    """

    block: Array
    states: Array
    seen: Array
    ladder: Array


PLANT = Layout(
    Plant, 0, top=(2 * ORDER,), bottom=(2 * ORDER,), delta=(3, ORDER, ORDER), enters=(3, ORDER),
    rows=(ORDER + SERIES + 1, ORDER), markov=(EULERS + ORDER + 2,), a=(ORDER + 1,), b=(ORDER + 1,),
    matrix=(ORDER, ORDER), other=(ORDER, ORDER), fl=(ORDER + 2, ORDER + 2),
    numbers=(4,),
)  # fmt: skip
LAW = Layout(
    Law, PLANT.end, num=(MOST,), den=(MOST,), moves=(4, 4), enters=(4,), leads=(4,),
    residues=(4,), numbers=(8,),
)  # fmt: skip
MOTION = Layout(
    Motion, LAW.end, output=(SIZE,), effort=(SIZE,), output_moves=(SIZE,),
    effort_moves=(SIZE,), start=(SIZE,), numbers=(2,), re=(WIDE,), im=(WIDE,), room=(6, WIDE),
    wr=(WIDE, WIDE), wi=(WIDE, WIDE), shares=(4, WIDE), turn=(SIZE,), creeping=(SIZE,),
)  # fmt: skip
PIECES = Layout(
    Pieces, MOTION.end, y0=(2, SIZE), y1=(2, SIZE), slope0=(2, SIZE), slope1=(2, SIZE),
    state=(3, ORDER, SIZE), input=(2, SIZE), ends=(3,), series=(TAYLOR + ORDER + 1,),
    derivatives=(TAYLOR + ORDER + 1,), bernstein=(BERNSTEIN + 1,), bends=(3, ORDER + 2),
)  # fmt: skip
LINES = Layout(
    Lines, PIECES.end, num=(MOST,), den=(MOST,), nn=(MOST,), dd=(MOST,), aa=(MOST,), bb=(MOST,),
    some=(MOST,), rest=(MOST,), roots=(MOST,), edges=(MOST,), parts=(4, MOST), work=(MOST, MOST),
    grid=(2, MOST), over=(MOST, SIDES), under=(MOST, SIDES), sides=(NOTES + MOST, SIDES),
)  # fmt: skip
TRACK = Layout(
    Track, LINES.end, block=(WIDE + 4, ROOM), states=(KEPT, WIDE),
    seen=(SEEN,), ladder=(LEVELS + DOUBLINGS + 1, WIDE, WIDE),
)  # fmt: skip
LENGTH = TRACK.end

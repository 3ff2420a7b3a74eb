"""Room for loops side by side: rows of numbers, a loop a lane; behind that of a single one."""

from typing import NamedTuple

from zoh.batch.arrays.rows import Array
from zoh.batch.compiled import room
from zoh.batch.compiled.layout import Layout

LOOPS = 16  # lanes: enough that the compiler keeps them a loop, few enough for the nearest memory
QUOTIENTS = 3 * LOOPS  # side by side: three of each loop
_POWERS = 5  # of a loop, at most
# rows of a plant: what it is (then in samples, then in the unit), its sample time, p where it
# crosses; the norm of A dt, the unit, by how many halvings, with how many terms; the motion by a
# sample; Markov's first two parameters; the transfer function; a[rest]/b[0], and how far off the
# gain at rest has come out; what is asked, and what gain there is at x and what turn is missing
(
    A0, A1, B0, B1, DT, X, REACH, UNIT, HALVINGS, TERMS, DELTA, _, _, _, ENTERS, _, FIRST, SECOND,
    TOP, _, _, BOTTOM, _, _, AT_REST, OFF, PM_DEG, GAIN, THETA, COSINE, SINE,
) = range(31)  # fmt: skip
_SEARCH, _FOUND, _VALLEYS, _WORK = 9, 7, room.NOTES + _POWERS, 10  # rows of those who use them
_LAW = 15  # numbers of a law besides its transfer function


class Abreast(NamedTuple):
    """A loop a lane.

    plant   see above;  law_num, law_den  of the controller in p;  num, den  of the loop in u
    law     a lane a row: what else of ``room.Law`` the motion needs, and the gains;  loop  which
    nn, dd, aa, bb  squares of |num|, |den|, |num + den|, |den - num| on the axis;  some, rest  room
    search, over, under, valleys, sizes, roots, room  of those who look for something
    found, fine, said  what there is, 1.0 where it is proved, whether the loop is stable
    re, im, turn, growth, wr, wi  of the modes (growth: |z|^2 - 1), as in ``room.Motion``
    """

    plant: Array
    law: Array
    loop: Array
    law_num: Array
    law_den: Array
    num: Array
    den: Array
    nn: Array
    dd: Array
    aa: Array
    bb: Array
    some: Array
    rest: Array
    search: Array
    found: Array
    fine: Array
    said: Array
    over: Array
    under: Array
    valleys: Array
    sizes: Array
    room: Array
    roots: Array
    re: Array
    im: Array
    turn: Array
    growth: Array
    wr: Array
    wi: Array


_LINE, _MODES = (_POWERS, LOOPS), (_POWERS - 1, LOOPS)
_SHARES = ((_POWERS - 1) ** 2, LOOPS)
ABREAST = Layout(
    Abreast, room.LENGTH, plant=(31, LOOPS), law=(LOOPS, _LAW), loop=(LOOPS,),
    law_num=(3, LOOPS), law_den=(3, LOOPS), num=_LINE, den=_LINE, nn=_LINE, dd=_LINE, aa=_LINE,
    bb=_LINE, some=_LINE, rest=_LINE, search=(_SEARCH, LOOPS), found=(_FOUND, LOOPS),
    fine=(LOOPS,), said=(2, LOOPS), over=(_POWERS, QUOTIENTS), under=(_POWERS, QUOTIENTS),
    valleys=(_VALLEYS, QUOTIENTS), sizes=(4, QUOTIENTS), room=(_WORK, LOOPS),
    roots=(2 * (_POWERS - 1), LOOPS), re=_MODES, im=_MODES, turn=_MODES, growth=_MODES,
    wr=_SHARES, wi=_SHARES,
)  # fmt: skip
LENGTH = ABREAST.end

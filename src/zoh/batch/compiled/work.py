"""The arrays of a loop, and of loops side by side, as compiled code sees them, by their address."""

from zoh.batch.compiled import room
from zoh.batch.compiled.abreast.room import ABREAST
from zoh.batch.compiled.addresses import arrays

plant, law, motion = arrays(room.PLANT), arrays(room.LAW), arrays(room.MOTION)
pieces, lines, track = arrays(room.PIECES), arrays(room.LINES), arrays(room.TRACK)
abreast = arrays(ABREAST)

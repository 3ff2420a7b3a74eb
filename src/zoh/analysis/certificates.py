"""Why a figure misses nothing: proofs, and the certificate that has one for each kind."""

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True, kw_only=True)
class Proof:
    """Why one figure misses nothing.

    holds   whether it is proved
    method  "Routh", "Descartes" or, on parts of the axis, "halving" (exact counts of a
            polynomial's roots), "discs" (bounds between the points of a grid), "bound" (nothing
            to prove), or "none"
    detail  what was counted or bounded
    """

    holds: bool
    method: str
    detail: str

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {"holds": self.holds, "method": self.method, "detail": self.detail}


@dataclass(frozen=True, slots=True, kw_only=True)
class Certificate:
    """Proofs that no crossing was missed and no peak is higher; one for each kind of figure.

    Peaks are proved to 1e-9 of themselves, to 1e-6 where a delay leaves no polynomial; crossings
    of a continuous dead time up to the frequency that is said, beyond which none decides the gain
    margin, to 1e-9 of it.
    """

    stable: Proof
    gain_crossings: Proof
    phase_crossings: Proof
    modulus_margin: Proof
    mt: Proof
    disk_margin: Proof
    bandwidth: Proof

    @property
    def holds(self) -> bool:
        """Return whether all of it is proved."""
        return not self.open()

    def open(self) -> list[str]:
        """Return the names of the figures that are not proved."""
        return [name for name in self.__slots__ if not getattr(self, name).holds]

    def to_dict(self) -> dict[str, Any]:
        """Return the JSON form."""
        return {"holds": self.holds} | {n: getattr(self, n).to_dict() for n in self.__slots__}

"""Fixed second-order sections in series with a law: a notch, or any pair over any pair.

    S(w) = (vp/vz)^2 (w^2 + 2 zz vz w + vz^2)/(w^2 + 2 zp vp w + vp^2)

with v = (2/dt) tan(w0 dt/2), so that a section is at the real frequency that it names, at any
sample time; its gain at w = 0 is 1. A law is solved on section times plant, which makes the
whole exact.
Source: G. F. Franklin, J. D. Powell, M. L. Workman, Digital Control of Dynamic Systems, 3rd ed.,
sec. 6.1 (prewarping, the notch its example).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

from zoh import checks
from zoh.errors import SpecError
from zoh.lti.systems import Plant, Sampled
from zoh.lti.wplane import warp


@dataclass(frozen=True, slots=True, kw_only=True)
class SecondOrder:
    """A pair of zeros over a pair of poles.

    zeros_w0, poles_w0      rad/s, real frequencies below Nyquist's
    zeros_zeta, poles_zeta  damping; 0 or more for the zeros, above 0 for the poles
    """

    zeros_w0: float
    zeros_zeta: float
    poles_w0: float
    poles_zeta: float

    def __post_init__(self) -> None:
        for name in ("zeros_w0", "poles_w0", "poles_zeta"):
            checks.positive(name, getattr(self, name))
        checks.not_negative("zeros_zeta", self.zeros_zeta)

    def in_s(self) -> Plant:
        """Return the section as a continuous system.

        >>> abs(SecondOrder(zeros_w0=2, zeros_zeta=0, poles_w0=2, poles_zeta=1).in_s().at(2.0))
        0.0
        """
        wz, wp = float(self.zeros_w0), float(self.poles_w0)
        return Plant(
            num=((wp / wz) ** 2, 2 * self.zeros_zeta * wp * (wp / wz), wp * wp),
            den=(1.0, 2 * self.poles_zeta * wp, wp * wp),
        )

    def at_clock(self, dt: float) -> Sampled:
        """Return the section at this sample time; raise SpecError for w0 not below Nyquist."""
        for name in ("zeros_w0", "poles_w0"):
            if not getattr(self, name) * dt < pi:
                bound = f"must be below the Nyquist frequency pi/dt = {pi / dt:.6g} rad/s"
                called = "w0" if self.zeros_w0 == self.poles_w0 else name  # a notch has one
                raise SpecError(called, bound, getattr(self, name), "lower it, or sample faster")
        vz, vp = warp(self.zeros_w0, dt), warp(self.poles_w0, dt)
        return Sampled.from_w(
            num_w=((vp / vz) ** 2, 2 * self.zeros_zeta * vp * (vp / vz), vp * vp),
            den_w=(1.0, 2 * self.poles_zeta * vp, vp * vp),
            dt=dt,
        )


def notch(*, w0: float, depth: float = 0.1, width: float = 1.0) -> SecondOrder:
    """Return the notch of gain ``depth`` at w0 rad/s, ``width`` times w0 wide, 1 elsewhere.

    The width is that of its poles, 2 zp, in the w-plane: in real frequencies it is narrower by
    sin(w0 dt)/(w0 dt), next to nothing well below Nyquist's. Depth 0 silences w0. Raises
    SpecError unless 0 <= depth < 1 and width > 0.

    >>> abs(notch(w0=2.0, depth=0.1).at_clock(0.5).at(2.0))
    0.1...
    """
    depth = checks.not_negative("depth", depth, "give the gain at w0")
    if not depth < 1:
        raise SpecError("depth", "must be below 1", depth, "a notch takes away")
    w0 = checks.positive("w0", w0, "give the frequency to be silenced in rad/s")
    width = checks.positive("width", width, "give the width as a share of w0")
    return SecondOrder(zeros_w0=w0, zeros_zeta=depth * width / 2, poles_w0=w0, poles_zeta=width / 2)


def listed(sections: object) -> tuple[SecondOrder, ...]:
    """Return the sections as they are; raise SpecError for what is no list of them."""
    if not isinstance(sections, list | tuple):
        way_out = "put it in brackets: [zoh.notch(w0=...)]"
        raise SpecError("sections", "must be a list of sections", sections, way_out)
    for i, section in enumerate(sections):
        if not isinstance(section, SecondOrder):
            way_out = "zoh.notch(w0=...) or zoh.SecondOrder(...)"
            raise SpecError(f"sections[{i}]", "must be a section", section, way_out)
    return tuple(sections)


def in_series(sections: Sequence[SecondOrder], dt: float) -> Sampled | None:
    """Return the sections' product, None where there is none; SpecError for what is no section."""
    product: Sampled | None = None
    for section in listed(sections):
        one = section.at_clock(dt)
        product = one if product is None else product * one
    return product

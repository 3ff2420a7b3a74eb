"""Everything that a firmware project needs of a controller, as texts by file name."""

from collections.abc import Sequence

from zoh.errors import SpecError
from zoh.firmware.asked import Design
from zoh.firmware.c import emit
from zoh.firmware.equality import Equality
from zoh.firmware.plan import Plan
from zoh.firmware.plan import plan as planned_as
from zoh.firmware.readme import readme
from zoh.firmware.wiring import examples

TARGETS = ("c",)


def export(
    design: Design | Plan, *, target: str = "c", number: str | None = None,
    proof: Equality | None = None,
) -> dict[str, str]:  # fmt: skip
    """Return the firmware of a design as {file name: text}; nothing is written.

    design   a verified design, or its plan, which has limits and ranges, too
    number   f32, f64, q31, q15 or auto; f32 if left out; a plan has one already
    target   "c": C99 that is C++17, too, with an Arduino sketch, an STM32 example and a README
    proof    what ``zoh.prove`` returned of the same plan: its costs are said in header and README

    >>> import zoh
    >>> d = zoh.p(zoh.Plant(num=[1], den=[1, 0]), dt=1.0, pm_deg=45)
    >>> sorted(export(d))
    ['README.md', 'controller.c', 'controller.h', 'controller_arduino.ino', 'controller_stm32.c']
    """
    return texts([planned(design, number)], target=target, proofs=[proof])


def texts(
    plans: Sequence[Plan], *, target: str = "c", proofs: Sequence[Equality | None]
) -> dict[str, str]:
    """Return the same of several controllers, with one README."""
    if target not in TARGETS:
        raise SpecError("target", "must be c", target, 'choose "c"')
    files: dict[str, str] = {}
    taken: set[str] = set()
    for made, proof in zip(plans, proofs, strict=True):
        if made.name.upper() in taken:  # of macros, and of files where capitals do not count
            raise SpecError("name", "must differ in more than capitals", made.name, "name it anew")
        taken.add(made.name.upper())
        if proof is not None and (proof.name, proof.sha256) != (made.name, made.sha256):
            raise SpecError("proof", "must be of this plan", proof.name, "prove it anew")
        if proof is not None and not proof.holds:
            raise SpecError(
                "proof",
                "must hold",
                next(iter(proof.differences), "no build"),
                "such code is not exported",
            )
        files |= {**emit(made, () if proof is None else proof.costs), **examples(made)}
    return {**files, "README.md": readme(plans, proofs)}


def planned(design: Design | Plan, number: str | None) -> Plan:
    """Return the plan of what is a design, or a plan already."""
    if isinstance(design, Plan):
        if number not in (None, design.number):
            bound = f"must be the plan's, {design.number}, or be left out"
            raise SpecError("number", bound, number, "plan the design again with it")
        return design
    return planned_as(design, number="f32" if number is None else number)

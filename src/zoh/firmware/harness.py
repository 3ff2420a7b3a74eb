"""The C around a controller under proof: what calls it, and what counts while it runs."""

from zoh.firmware.lines import Number
from zoh.firmware.words import result_type

STEP, TRACK, RESET, INIT, END = range(5)  # what a sample asks for, as the C below reads it
RUN, SIZE, COUNT = "zoh_run", "zoh_size", "zoh_count"
ROUTINES = ("init", "reset", "step", "track", "selftest")


def driver(name: str, number: Number) -> str:
    """Return the C that calls a controller sample by sample, until it is asked for the END.

    Its arguments are four pointers, so it is called in the same way whether floats travel in
    registers of their own or not.
    """
    kind = result_type(number)
    head = f"void {RUN}({name}_state *s, const uint8_t *what, const {kind} *given, {kind} *out)"
    return (
        f'#include "{name}.h"\n\nuint32_t {SIZE}(void);\n{head};\n\n'
        f"uint32_t {SIZE}(void) {{ return (uint32_t)sizeof({name}_state); }}\n\n"
        f"{head}\n{{\n"
        f"    for (; *what != {END}; what++, out++, given += 4) {{\n"
        "        *out = 0;\n"
        f"        if (*what == {STEP}) *out = {name}_step(s, given[0], given[1], given[2]);\n"
        f"        else if (*what == {TRACK})"
        f" {name}_track(s, given[0], given[1], given[2], given[3]);\n"
        f"        else if (*what == {RESET}) {name}_reset(s, given[3]);\n"
        f"        else {name}_init(s);\n"
        "    }\n}\n"
    )


# Called by the emulator before every instruction. What runs between the entry of step and the next
# instruction of the driver is one sample; the driver's own instructions are not counted. The stack
# pointer is read in the first samples alone: reading it costs more than all the rest.
COUNTER = """\
#include <stdint.h>

typedef struct {
    uint64_t entry, first, last;
    int (*read)(void *, int, void *);
    int64_t pointer, probes;
    uint64_t running, now, samples, least, most, total;
    uint32_t top, deepest;
} counts;

void zoh_count(void *emulator, uint64_t address, uint32_t size, counts *c)
{
    uint32_t at = 0;
    (void)size;
    if (address == c->entry) {
        c->running = 1;
        c->now = 0;
        if (c->probes > 0) c->read(emulator, (int)c->pointer, &c->top);
    }
    if (!c->running) return;
    if (address >= c->first && address < c->last) {
        c->running = 0;
        c->samples += 1;
        c->probes -= 1;
        c->total += c->now;
        if (c->now < c->least) c->least = c->now;
        if (c->now > c->most) c->most = c->now;
        return;
    }
    c->now += 1;
    if (c->probes > 0) {
        c->read(emulator, (int)c->pointer, &at);
        if (c->top - at > c->deepest) c->deepest = c->top - at;
    }
}
"""

# One flat image: code, then constants. Nothing of a controller may be garbage to the linker.
LINK = """\
ENTRY(zoh_run)
SECTIONS {
  . = 0x10000;
  .text : { KEEP(*(.text.zoh_* .text.%(name)s_*)) *(.text .text.*) }
  .rodata : { *(.rodata .rodata.* .srodata .srodata.*) }
  .data : { *(.data .data.* .sdata .sdata.*) }
  .bss : { *(.bss .bss.* .sbss .sbss.* COMMON) }
  /DISCARD/ : { *(.ARM.exidx* .ARM.extab* .eh_frame*) }
}
"""

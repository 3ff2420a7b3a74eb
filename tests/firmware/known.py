"""Two PI controllers written by hand, in C and in Python: what the harness itself is tested with.

u = sat(kp e + i + ff), i <- i + ki e, e = r - y; the float one holds what is not finite. Each has
its coefficients where a test can find and change them.
"""

import struct
from math import isfinite

import numpy as np

from zoh.firmware.comparison import Subject

HEADER = """\
#include <stdint.h>
typedef struct {{ {members} }} pi_state;
void pi_init(pi_state *s);
void pi_reset(pi_state *s, {kind} u0);
{kind} pi_step(pi_state *s, {kind} r, {kind} y, {kind} ff);
void pi_track(pi_state *s, {kind} r, {kind} y, {kind} ff, {kind} u_manual);
int32_t pi_selftest(void);
"""
FLOAT = """\
#include "pi.h"
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#endif
static const float kp = 0.7f, ki = 0.1f;
void pi_init(pi_state *s) { s->faults = 0; pi_reset(s, 0.0f); }
void pi_reset(pi_state *s, float u0) { s->i = u0; s->u = u0; }
float pi_step(pi_state *s, float r, float y, float ff)
{
    float e = r - y;
    float v = kp * e + s->i;
    float u = v + ff;
    float i = s->i + ki * e;
    if (u > 10.0f) u = 10.0f;
    if (u < -10.0f) u = -10.0f;
    if (((u + i) - (u + i)) >= 0.0f) { s->i = i; s->u = u; } else { s->faults++; }
    return s->u;
}
void pi_track(pi_state *s, float r, float y, float ff, float u_manual)
{
    float law = u_manual - ff;
    float i = law - kp * (r - y);
    if ((i - i) >= 0.0f) { s->i = i; s->u = u_manual; } else { s->faults++; }
}
int32_t pi_selftest(void)
{
    pi_state s;
    pi_init(&s);
    return pi_step(&s, 1.0f, 0.0f, 0.5f) == 1.2f ? 0 : 1;
}
"""
WHOLE = """\
#include "pi.h"
static const int32_t kp = 90, ki = 13;
void pi_init(pi_state *s) { pi_reset(s, 0); }
void pi_reset(pi_state *s, int16_t u0) { s->i = u0 * 256; }
static int32_t held(int32_t x) { return x > 8388607 ? 8388607 : x < -8388608 ? -8388608 : x; }
int16_t pi_step(pi_state *s, int16_t r, int16_t y, int16_t ff)
{
    int32_t e = r - y;
    int32_t u = ((kp * e + s->i) >> 8) + ff;
    s->i = held(s->i + ki * e);
    return (int16_t)(u > 32767 ? 32767 : u < -32768 ? -32768 : u);
}
void pi_track(pi_state *s, int16_t r, int16_t y, int16_t ff, int16_t u_manual)
{
    s->i = held((u_manual - ff) * 256 - kp * (r - y));
}
int32_t pi_selftest(void)
{
    pi_state s;
    pi_init(&s);
    return pi_step(&s, 256, 0, 5) == 95 ? 0 : 1;
}
"""


class FloatModel:
    """The float controller, each operation rounded."""

    kp, ki = np.float32(0.7), np.float32(0.1)

    def __init__(self):
        self.i = self.u = np.float32(0)
        self.faults = 0

    def reset(self, u0):
        self.i = self.u = np.float32(u0)

    def step(self, r, y, ff=0):
        with np.errstate(all="ignore"):
            r, y, ff = np.float32(r), np.float32(y), np.float32(ff)
            e = r - y
            u = self.kp * e + self.i + ff
            i = self.i + self.ki * e
            u = np.float32(10) if u > 10 else np.float32(-10) if u < -10 else u
            if isfinite(u + i):
                self.i, self.u = i, u
            else:
                self.faults += 1
        return self.u

    def track(self, r, y, ff, u_manual):
        with np.errstate(all="ignore"):
            law = np.float32(u_manual) - np.float32(ff)
            i = law - self.kp * (np.float32(r) - np.float32(y))
            if isfinite(i):
                self.i, self.u = i, np.float32(u_manual)
            else:
                self.faults += 1

    def state_bytes(self):
        return struct.pack("<ffI", self.i, self.u, self.faults)


class WholeModel:
    """The whole-number controller."""

    def __init__(self):
        self.i = 0

    def reset(self, u0):
        self.i = int(u0) * 256

    def step(self, r, y, ff=0):
        e = int(r) - int(y)
        u = ((90 * e + self.i) >> 8) + int(ff)
        self.i = _held(self.i + 13 * e)
        return min(32767, max(-32768, u))

    def track(self, r, y, ff, u_manual):
        self.i = _held((int(u_manual) - int(ff)) * 256 - 90 * (int(r) - int(y)))

    def state_bytes(self):
        return struct.pack("<i", self.i)


def _held(x):
    return min(8388607, max(-8388608, x))


def float_pi(edit=lambda text: text):
    header = HEADER.format(members="float i; float u; uint32_t faults;", kind="float")
    sources = {"pi.h": header, "pi.c": edit(FLOAT)}
    return Subject(name="pi", number="f32", sources=sources, begin=FloatModel)


def whole_pi(edit=lambda text: text):
    header = HEADER.format(members="int32_t i;", kind="int16_t")
    return Subject(
        name="pi", number="q15", sources={"pi.h": header, "pi.c": edit(WHOLE)}, begin=WholeModel
    )

"""Verified controllers as firmware that is the same controller, bit for bit.

What crosses this room's doors:

    plan.plan(verified, ...) -> Plan          what is to be built, quantised and verified again
    c.emit(plan) -> {"NAME.h": ..., "NAME.c": ...}
    model.Model(plan)                         the same arithmetic in Python, rounding by rounding
    vectors.hostile(plan, n)                  the inputs that equality is proved over
    head.Cost                                 what a proof measured, for emit(plan, costs)

The step is written once, as lines (``lines.py``): the model runs them, ``ranges`` and ``solver``
prove them, ``c`` prints them. The C functions of a plan called NAME, u_t being float, double,
int32_t or int16_t, as r, y and ff are::

    void    NAME_init(NAME_state *s);
    void    NAME_reset(NAME_state *s, u_t u0);
    u_t     NAME_step(NAME_state *s, u_t r, u_t y, u_t ff);
    void    NAME_track(NAME_state *s, u_t r, u_t y, u_t ff, u_t u_manual);
    int32_t NAME_selftest(void);              0, or the first sample that differs, counted from 1

NAME_state has no padding: all its members have one size, in the order of ``plan.program.states``
(f32: float, q15: int32_t, f64: double, q31: int64_t), and floats are followed by the fault counter
``faults``, uint32_t for f32 and uint64_t for f64.
"""

"""zoh, through its public names, from what each form of a loop gives."""

import warnings

from benchmarks.torture.loops import Spec
from benchmarks.torture.score import Answer

import zoh

VERSION = f"zoh {zoh.__version__}"


def loop(spec: Spec) -> zoh.Plant | zoh.Sampled:
    """Return the open loop the way a user of zoh writes it."""
    if spec["form"] == "z":
        return zoh.Sampled(num=spec["num"], den=spec["den"], dt=spec["dt"])
    if spec["form"] == "s":
        return zoh.Plant(num=spec["num"], den=spec["den"], dead_time=spec["dead_time"])
    plant, law, dt = zoh.Plant(**spec["plant"]), spec["controller"], spec["dt"]
    if "num" in law:
        controller = zoh.Sampled(num=law["num"], den=law["den"], dt=dt)
    else:
        kp, ki, kd = law["kp"], law["ki"], law["kd"]
        # kp + ki/w + kd w/(1 + w dt/2), over one denominator
        num = [kp * dt / 2 + kd, kp + ki * dt / 2, ki]
        den = [dt / 2, 1.0, 0.0]
        if not kd:
            num, den = [kp, ki], [1.0, 0.0]
        if not ki:
            num, den = num[:-1], den[:-1]
        controller = zoh.Sampled.from_w(num_w=num, den_w=den, dt=dt)
    return zoh.sample(plant, dt) * controller


def answer(spec: Spec) -> Answer:
    try:
        with warnings.catch_warnings():  # the truth of rounded coefficients is that of these
            warnings.simplefilter("ignore", zoh.AccuracyWarning)
            m = zoh.margins(loop(spec))
    except Exception as error:  # whatever a tool raises is its answer
        return Answer(error=f"{type(error).__name__}: {error}")
    return Answer(
        stable=m.stable, gm=m.gain_margin, pm_deg=m.phase_margin_deg, ms=m.ms,
        gains=m.gain_crossings, phases=m.phase_crossings, mt=m.mt, disk=m.disk_margin,
        delay=m.delay_margin,
    )  # fmt: skip

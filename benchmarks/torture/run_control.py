"""python-control: ``stability_margins`` with every crossing, by its default and by 'poly'.

Of several crossings the margin is taken as the library takes it: the gain nearest 1 in log, the
phase smallest in magnitude.
"""

import warnings
from functools import partial

import numpy as np
from benchmarks.torture.loops import Spec
from benchmarks.torture.score import Answer

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import control

VERSION = f"python-control {control.__version__}"


def loop(spec: Spec) -> control.TransferFunction | str:
    """Return the open loop, or what it is that python-control cannot say."""
    if spec["form"] == "z":
        return control.tf(spec["num"], spec["den"], spec["dt"])
    if spec["form"] == "s":
        if spec["dead_time"]:
            return "dead time in a continuous loop"
        return control.tf(spec["num"], spec["den"])
    plant, law, dt = spec["plant"], spec["controller"], spec["dt"]
    samples = plant["dead_time"] / dt
    if abs(samples - round(samples)) > 1e-9:
        return "dead time of a fraction of a sample"
    sampled = control.c2d(control.tf(plant["num"], plant["den"]), dt, "zoh")
    sampled = sampled * control.tf([1.0], [1.0] + [0.0] * round(samples), dt)
    if "num" in law:
        return sampled * control.tf(law["num"], law["den"], dt)
    controller = control.tf([law["kp"]], [1.0], dt)
    if law["ki"]:
        half = law["ki"] * dt / 2
        controller = controller + control.tf([half, half], [1.0, -1.0], dt)
    if law["kd"]:
        controller = controller + control.tf([law["kd"] / dt, -law["kd"] / dt], [1.0, 0.0], dt)
    return sampled * controller


def answer(spec: Spec, method: str = "best") -> Answer:
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        try:
            made = loop(spec)
            if isinstance(made, str):
                return Answer(cannot=made)
            return _margins(made, method)
        except Exception as error:  # whatever a tool raises is its answer
            return Answer(error=f"{type(error).__name__}: {error}")


def _margins(made: control.TransferFunction, method: str) -> Answer:
    gm, pm, sm, w_phase, w_gain, _ = control.stability_margins(made, returnall=True, method=method)
    poles = control.feedback(made, 1).poles()
    stable = bool((abs(poles) < 1).all() if made.isdtime() else (poles.real < 0).all())
    least = float(np.min(sm)) if len(sm) else np.inf
    logs = np.abs(np.log(np.where(gm > 0, gm, np.inf)))
    return Answer(
        stable=stable,
        gm=float(gm[np.argmin(logs)]) if len(gm) else np.inf,
        pm_deg=float(pm[np.argmin(np.abs(pm))]) if len(pm) else np.inf,
        ms=1 / least if least else np.inf,
        gains=tuple(zip(w_gain.tolist(), pm.tolist(), strict=True)),
        phases=tuple(zip(w_phase.tolist(), gm.tolist(), strict=True)),
    )


by_polynomials = partial(answer, method="poly")

"""One request, judged: met, refused rightly, or wrong and in which way.

A design is asked of analysis alone. A refusal is wrong where the dense search finds a controller,
where its best margin or its nearest crossover is not had by a design made there, or where the
search finds a better margin, or a crossover that is nearer, than they say.
"""

from math import pi

from benchmarks.requests.dense import candidates, meets
from benchmarks.requests.drawn import Request

import zoh
from zoh.solving import solved
from zoh.spec import Crossover

NEAR = 1e-6  # deg, and of wc: how near to what a refusal offers a design must be


def judge(request: Request) -> str:
    """Return "met", "infeasible" or "not met", where right; else "WRONG: ..."."""
    try:
        return _judged(request)
    except zoh.SpecError as foreign:  # every request drawn is a sound one
        return f"WRONG: {foreign}"


def _judged(request: Request) -> str:
    asked = request.parameters
    wc, pm_deg, dt = asked["wc"], asked["pm_deg"], request.sampled.dt
    try:
        d = zoh.design(request.plant, request.law, asked, dt=dt)
    except zoh.Infeasible as refused:
        return _offers(request, refused) or _denied(request, wc, pm_deg) or "infeasible"
    except zoh.NotMet:
        return _denied(request, wc, pm_deg) or "not met"
    if not meets(request.sampled, d.controller, wc, pm_deg):
        return "WRONG: the design does not meet its request"
    if not all(value > 0 for name, value in d.gains.items()):
        return "WRONG: a gain is not positive"
    return "met"


def _denied(request: Request, wc: float, pm_deg: float) -> str | None:
    for found in candidates(request, wc, pm_deg):
        if meets(request.sampled, found, wc, pm_deg):
            return f"WRONG: refused, but {found.num_w} over {found.den_w} is one"
    return None


def _made(request: Request, wc: float, pm_deg: float) -> bool:
    """Return whether the law solved there meets that; its step, long at an edge, says nothing."""
    asked = request.parameters | {"wc": wc, "pm_deg": pm_deg}
    try:
        law = solved(request.law, request.sampled, Crossover(wc=wc, pm_deg=pm_deg), asked)
    except zoh.Infeasible:
        return False
    return meets(request.sampled, law.controller, wc, pm_deg)


def _offers(request: Request, refused: zoh.Infeasible) -> str | None:
    wc, pm_deg = request.parameters["wc"], request.parameters["pm_deg"]
    best, nearest = refused.best_pm_deg, refused.nearest_wc
    had = best is not None and (_made(request, wc, best - NEAR) or _made(request, wc, best))
    if best is not None and not had:
        return f"WRONG: nothing has the best margin, {best!r} deg"
    for step in range(1, 60):  # a better margin, three degrees at a time
        better = (best or 0.0) + NEAR + 3 * (step - 0.5)
        if better < 180 and _denied(request, wc, better):
            return f"WRONG: {better!r} deg is better than the best margin, {best!r} deg"
    if nearest is not None and not _made(request, nearest, pm_deg):
        return f"WRONG: nothing crosses over at the nearest crossover, {nearest!r} rad/s"
    for step in range(1, 40):  # a nearer crossover, as far away as is claimed, on both sides
        for side in (-1, 1):
            nearer = wc * 1.17 ** (side * (step - 0.37))
            away = max(nearer / wc, wc / nearer)
            limit = 1e3 if nearest is None else max(nearest / wc, wc / nearest)
            inside = away < limit * (1 - NEAR) and nearer < pi / request.sampled.dt
            if inside and _denied(request, nearer, pm_deg):
                return f"WRONG: {nearer!r} rad/s is nearer than the nearest, {nearest!r} rad/s"
    return None

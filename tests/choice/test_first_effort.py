"""What the first effort of a step tells before the step is followed, and what it may not."""

from random import Random

import pytest
from benchmarks.choice.attack import drawn

import zoh
from zoh.choice.freedom import Freedom
from zoh.choice.judge import Judge
from zoh.solving import solved
from zoh.spec import Crossover

DT = 0.1
ARM = zoh.Plant(num=[2.3], den=[1, 0.7809, 0], sensor=12 / 180)
AT_ONCE = zoh.Plant(num=[0.2, 1.0], den=[1.0, 3.0], sensor=0.5)
LATE = zoh.Plant(num=[0.2, 1.0], den=[1.0, 3.0], sensor=0.5, dead_time=0.04)
NOTCH = zoh.notch(w0=8.0, depth=0.2)


@pytest.mark.parametrize(
    ("plant", "law", "given", "sections", "weights"),
    [
        (ARM, "lead", {"wc": 2.0, "pm_deg": 50, "dc_gain": 20}, (), {}),
        (ARM, "pd", {"wc": 2.0, "pm_deg": 50}, (NOTCH,), {}),
        (ARM, "pd", {"wc": 2.0, "pm_deg": 50}, (NOTCH,), {"derivative_weight": 0.0}),
        (ARM, "pid", {"wc": 2.0, "pm_deg": 50, "ki": 4.0}, (), {"setpoint_weight": 0.3}),
        (AT_ONCE, "pi", {"wc": 2.0, "pm_deg": 110}, (), {}),
        (AT_ONCE, "pi", {"wc": 2.0, "pm_deg": 110}, (NOTCH,), {"setpoint_weight": 0.5}),
        (LATE, "pi", {"wc": 2.0, "pm_deg": 100}, (), {}),
    ],
)
def test_the_first_effort_is_that_of_the_step_followed(plant, law, given, sections, weights):
    d = zoh.design(plant, law, {**given, **weights}, dt=DT, sections=sections)
    first = zoh.trace(
        plant, d.controller, reference=-3.0, t_end=DT, feedforward=d.feedforward
    ).u[0]  # fmt: skip
    fixed = sections[0].at_clock(DT) if sections else None
    behind = zoh.sample(plant, DT)
    judge = Judge(
        plant=plant, sampled=behind * fixed if fixed else behind, compute_delay=0.0,
        requirements=zoh.Requirements(effort_max=1e-3), reference=-3.0, fixed=fixed,
        weights=weights,
    )  # fmt: skip
    found = solved(law, judge.sampled, Crossover(wc=given["wc"], pm_deg=given["pm_deg"]), given)
    # slack is 1 - u/bound
    assert (1 - judge.effort_slack(found)) * 1e-3 == pytest.approx(first, rel=1e-9)


def test_what_the_first_effort_condemns_the_step_condemns_more():
    random, told = Random(5), 0
    for _ in range(60):
        task = drawn(random)
        sampled = zoh.sample(task.plant, task.dt)
        judge = Judge(
            plant=task.plant, sampled=sampled, compute_delay=0.0, reference=1.0,
            requirements=zoh.Requirements(peak_effort=1.0, effort_min=-0.5),
        )  # fmt: skip
        freedom = Freedom.of(task.law, sampled, 0.3, {}, 20.0)
        if freedom is None:
            continue
        parameters = freedom.parameters([0.4] * freedom.size)
        whole, soon = (judge.of(task.law, parameters, worth) for worth in (-1e9, -1.0))
        if not whole.rows:
            continue
        assert whole.height <= soon.height + 1e-9
        if soon.rows:
            assert soon == whole
        else:
            assert "in the first sample of a step it is" in soon.failed
            told += 1
    assert told >= 5


def test_a_bound_on_the_effort_does_not_follow_every_step_of_a_stiff_plant(monkeypatch):
    task, followed = drawn(Random(2)), []
    whole = Judge._in_time

    def counted(self, found):
        followed.append(found)
        return whole(self, found)

    monkeypatch.setattr(Judge, "_in_time", counted)
    d = zoh.design(task.plant, task.law, {}, dt=task.dt, requirements=task.asked)
    assert d.met
    assert d.step.peak_effort == pytest.approx(task.asked.peak_effort, rel=1e-3)  # it limits
    assert "peak_effort must be at most" in d.choice.limits[0]
    assert len(followed) < 1000  # of the 12,000 candidates that it looks at

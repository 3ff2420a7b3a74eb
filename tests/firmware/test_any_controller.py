"""Any controller in any format: the C on this machine is the model, and no value overflows."""

import pytest
from host import Host
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

import zoh
from zoh.firmware import solver
from zoh.firmware.lines import NUMBERS
from zoh.firmware.model import Model
from zoh.firmware.plan import plan
from zoh.firmware.vectors import hostile

# a lag that takes any of the controllers below into a stable loop, so that nothing is selected
PLANT = zoh.Plant(num=[0.01], den=[1.0, 1.0])
WINDUPS = ("auto", "conditional", "back_calculation", "tracking", "none")


def of_zeros_and_poles(gain, pairs, integrator):
    """Return the controller with these real zeros and poles of z, and one at z = 1 if asked."""
    num, den = [gain], [1.0]
    for zero, pole in pairs:
        num = [a - zero * b for a, b in zip([*num, 0.0], [0.0, *num], strict=True)]
        den = [a - pole * b for a, b in zip([*den, 0.0], [0.0, *den], strict=True)]
    if integrator:
        num = [a - 0.5 * b for a, b in zip([*num, 0.0], [0.0, *num], strict=True)]
        den = [a - b for a, b in zip([*den, 0.0], [0.0, *den], strict=True)]
    return zoh.Sampled(num=num, den=den, dt=0.1)


places = st.tuples(st.floats(-0.9, 0.95), st.floats(-0.5, 0.95))
controllers = st.builds(
    of_zeros_and_poles, st.floats(0.05, 8.0), st.lists(places, max_size=4), st.booleans()
)


def planned(controller, number, **options):
    """Return the plan; a request that says what does not fit it is none."""
    ends = {"y_range": (-2, 2), "u_range": (-40, 40)}
    try:
        return plan(zoh.verify(PLANT, controller), number=number, pm_loss_deg=5, **ends, **options)
    except zoh.ZohError:
        return None


@settings(max_examples=60)
@given(
    controller=controllers,
    number=st.sampled_from(NUMBERS),
    limit=st.none() | st.floats(0.5, 30.0),
    rate=st.none() | st.floats(1.0, 500.0),
    anti_windup=st.sampled_from(WINDUPS),
    realisation=st.sampled_from(("auto", "pid", "cascade", "delta")),
    start=st.integers(0, 2**32 - 1),
)
@example(
    controller=zoh.Sampled(num=[2.0, -1.5], den=[1.0, -1.0], dt=0.1), number="q15", limit=3.0,
    rate=5.0, anti_windup="back_calculation", realisation="pid", start=1,
)  # fmt: skip
def test_the_c_is_the_model(controller, number, limit, rate, anti_windup, realisation, start):
    ends = {} if limit is None else {"u_min": -limit, "u_max": limit / 2}
    made = planned(
        controller, number, rate=rate, anti_windup=anti_windup, realisation=realisation, **ends
    )
    assume(made is not None)
    model, host = Model(made), Host(made)
    for k, sample in enumerate(hostile(made, 500, start)):
        if k % 97 == 50:
            model.track(*sample, sample[0])
            host.track(*sample, sample[0])
        assert host.bits(model.step(*sample)) == host.bits(host.step(*sample))
    assert model.state_bytes() == host.state_bytes()
    assert host.selftest() == 0


@settings(max_examples=25)
@given(controller=controllers, number=st.sampled_from(("q15", "q31")))
def test_the_solver_excludes_overflow(controller, number):
    pytest.importorskip("z3")
    made = planned(controller, number)
    assume(made is not None)
    assert solver.overflow_excluded(made)

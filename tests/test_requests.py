"""A share of the campaign of random requests: each is met, or its refusal is right.

The whole of it is ``python -m benchmarks.requests --count 10000``.
"""

import pytest
from benchmarks.requests.drawn import LAWS, drawn
from benchmarks.requests.judged import judge


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # what is right counts, not how sure
@pytest.mark.parametrize("law", LAWS)
def test_random_requests_are_met_or_rightly_refused(law):
    verdicts = [judge(drawn(law, seed)) for seed in range(8)]
    assert [v for v in verdicts if v.startswith("WRONG")] == []
    assert verdicts.count("met") >= 1
    assert verdicts.count("infeasible") >= 1


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # as above
@pytest.mark.parametrize(
    ("law", "seed"),
    [
        ("pd", 11149),  # what works is 1.6 % wide, just below Nyquist's frequency
        ("pd", 17127),  # 1 % wide: the phase passes through all that the law gives there
        ("pd", 17248),
        ("leadlag", 5036),  # these three need more than the lag's own turn
        ("leadlag", 5038),
        ("leadlag", 5043),
    ],
)
def test_hard_refusals_are_right(law, seed):
    assert judge(drawn(law, seed)) == "infeasible"

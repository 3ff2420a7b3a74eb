"""A share of the campaign of random requests: each is met, or its refusal is right.

The whole of it is ``python -m benchmarks.requests --count 10000``.
"""

import pytest
from benchmarks.requests.drawn import LAWS, drawn
from benchmarks.requests.judged import judge

import zoh


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
        ("leadlag", 12383),  # its phases are 0.4 deg wide
        ("leadlag", 14280),  # 2 % wide, between two loops that cross over elsewhere
        ("leadlag", 5036),  # these three need more than the lag's own turn
        ("leadlag", 5038),
        ("leadlag", 5043),
    ],
)
def test_hard_refusals_are_right(law, seed):
    assert judge(drawn(law, seed)) == "infeasible"


def lying(monkeypatch, seed, **claims):
    """Return the verdict on a library whose refusals claim something else."""
    truth = zoh.design

    def design(*given, **options):
        try:
            return truth(*given, **options)
        except zoh.Infeasible as refused:
            refused.__dict__.update({k: claim(refused) for k, claim in claims.items()})
            raise

    request = drawn("pd", seed)
    assert judge(request) == "infeasible"
    with monkeypatch.context() as patch:
        patch.setattr(zoh, "design", design)
        return judge(request)


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # as above
def test_the_judge_is_not_taken_in(monkeypatch):
    """Offers that nothing keeps, offers kept back, a refusal of what can be had, a wrong loop."""
    farther = lying(monkeypatch, 17127, nearest_wc=lambda r: 1.1 * r.nearest_wc)
    assert "nothing crosses over at the nearest crossover" in farther
    nowhere = lying(monkeypatch, 17127, nearest_wc=lambda r: None)
    assert "is nearer than the nearest, None" in nowhere
    too_good = lying(monkeypatch, 17127, best_pm_deg=lambda r: r.best_pm_deg + 1e-3)
    assert "nothing has the best margin" in too_good
    modest = lying(monkeypatch, 17127, best_pm_deg=lambda r: r.best_pm_deg - 10)
    assert "is better than the best margin" in modest


@pytest.mark.filterwarnings("ignore::zoh.AccuracyWarning")  # as above
def test_the_judge_finds_what_was_refused_and_measures_what_was_made(monkeypatch):
    request = next(r for r in (drawn("pd", seed) for seed in range(40)) if judge(r) == "met")
    truth = zoh.design

    def refuse(*_, **__):
        raise zoh.Infeasible("no", needed_deg=0.0)

    monkeypatch.setattr(zoh, "design", refuse)
    assert "is better than the best margin, None" in judge(request)

    def other(plant, law, asked, **options):
        return truth(plant, law, {**asked, "pm_deg": asked["pm_deg"] + 1e-6}, **options)

    monkeypatch.setattr(zoh, "design", other)
    assert judge(request) == "WRONG: the design does not meet its request"

"""A state that was refitted in vain is tried once more, and then where it promises more than it did."""

import pytest

from imubench.diagnosis.criteria.dynamic_score import Screened
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves import add_dynamic
from imubench.diagnosis.search.moves.add_dynamic import state_trials
from imubench.effects import EFFECTS

SOFT, ROCKING = (Hypothesis(EFFECTS[name], "imu2") for name in ("soft_mount", "rocking_mount"))


@pytest.fixture
def search(hardly_counting, monkeypatch):
    """Return a search in which every refit is in vain: of what states promise, the names that are refitted."""
    fit, refitted = hardly_counting(300), []

    def begun(short, some, **_):
        refitted.append(some[0].hypothesis.name)
        return Trial(some[0].hypothesis, short, -200.0)  # so far below that nothing softer is begun

    def searched(vain, *promises):
        refitted.clear()
        screened = [Screened(h, nat, {}, {}) for h, nat in promises]
        monkeypatch.setattr(add_dynamic, "screen", lambda *_: screened)
        assert not state_trials(fit, [h for h, _ in promises], lambda _: None, vain=vain)
        return refitted.copy()

    monkeypatch.setattr(add_dynamic, "refit_from_screening", begun)
    monkeypatch.setattr(add_dynamic, "holds_its_law", lambda _: True)
    return searched


@pytest.mark.parametrize(("promise", "again"), [(30.0, False), (49.0, False), (60.0, True)])
def test_a_state_is_refitted_a_third_time_where_it_promises_more(promise, again, search):
    vain = {}
    assert search(vain, (SOFT, 49.0)) == [SOFT.name]
    assert search(vain, (SOFT, 48.0)) == [SOFT.name]  # a mount of 54 and 52 nat was worth nothing, and 76 beside a bias
    assert search(vain, (SOFT, promise)) == [SOFT.name] * again
    assert vain == {SOFT.name: [49.0, 48.0, 60.0] if again else [49.0, 48.0]}


def test_what_was_in_vain_hides_nothing_that_promises_less(search):
    assert search({}, (SOFT, 49.0), (ROCKING, 6.0)) == [SOFT.name, ROCKING.name]  # the next, for the first was nothing
    assert search({SOFT.name: [49.0, 49.0]}, (SOFT, 49.0), (ROCKING, 6.0)) == [ROCKING.name]

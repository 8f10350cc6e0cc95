"""A filter of both triples whose law holds at one of them is held against that one's alone."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Gain, Kept, Trial
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves import swap_for_one_triple as halved_module
from imubench.diagnosis.search.moves.swap_for_one_triple import FilterOfOneTriple, of_one
from imubench.effects import EFFECTS, VARIANTS
from tests.searching import moved

FILTERS = [Hypothesis(e, "imu2") for e in VARIANTS if e.name == "low_pass"]
BOTH = next(h for h in FILTERS if not h.effect.variant)
SCALE = Hypothesis(EFFECTS["accel_scale"], "imu2")


def filter_of(part):
    return next(h for h in FILTERS if h.effect.variant == part)


def with_laws(fit, gyro, accel):
    return replace(fit, noise=fit.noise | {BOTH.key("gyro"): gyro, BOTH.key("accel"): accel})


@pytest.mark.parametrize(
    ("gyro", "accel", "part"), [(0.2, 2.5, "gyro"), (1.6, 0.1, "accel"), (1.6, 2.5, None), (0.2, 0.1, None)]
)
def test_the_law_that_holds_says_which(gyro, accel, part, hardly_counting):
    fit = with_laws(hardly_counting(300), gyro, accel)
    assert of_one(fit, BOTH, [*FILTERS, SCALE]) == (filter_of(part) if part else None)
    assert of_one(fit, filter_of("gyro"), FILTERS) is None


@pytest.mark.parametrize(("nat", "foretells", "taken"), [(111, True, True), (111, False, False), (2, True, False)])
def test_it_is_taken_with_what_it_stood_for_where_both_are_better(nat, foretells, taken, hardly_counting, monkeypatch):
    fit = with_laws(hardly_counting(300), 0.2, 2.5)
    gain = Gain(30.0, 20.0, 40.0, np.ones(5)) if foretells else Gain(1.0, -20.0, 20.0, np.ones(5))
    monkeypatch.setattr(halved_module, "refit", lambda fit, *_: fit)
    monkeypatch.setattr(halved_module, "with_noise", lambda fit, *_: fit)
    monkeypatch.setattr(halved_module, "plain_scores", lambda *_: ([], []))
    monkeypatch.setattr(halved_module, "plain_trials", lambda fit, *_: [Trial(SCALE, fit, 1370.0)])
    monkeypatch.setattr(halved_module, "heldout_gain", lambda *_: gain)
    monkeypatch.setattr(halved_module, "aic_gain", lambda *_: nat)
    state = replace(fit.state, values=fit.state.values | {BOTH.key("cutoff"): np.array([2.6])})
    kept = [Kept(BOTH, 8835.0, gain, ())]
    now = moved(FilterOfOneTriple(), replace(fit, state=state), kept, everything=(*FILTERS, SCALE)).kept
    assert [k.hypothesis for k in now] == ([filter_of("gyro"), SCALE] if taken else [BOTH])
    if taken:
        assert now[0].rivals[0].hypothesis == BOTH

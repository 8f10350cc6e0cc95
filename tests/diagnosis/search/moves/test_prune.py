"""What the fit can do without: effects that predict nothing, starting clocks, and what the noise's colour may be."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.plausible_fit import natural
from imubench.diagnosis.criteria.trial import Gain, Kept
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves import drop as prune_module
from imubench.diagnosis.search.moves.drop import Drop, about_zero, firmly, in_colour, price_of_dropping, spare
from imubench.diagnosis.solve.refit import information, refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.searching import moved

NOTHING = Gain(0.0, 0.0, 0.0, np.zeros(1))


def test_an_effect_that_predicts_nothing_for_sure_is_spared():
    h = Hypothesis(EFFECTS["gyro_bias"], "imu1")
    sure, doubtful = (Gain(9.0, low, 20.0, np.array([9.0])) for low in (1.0, -4.0))
    fit = object()
    assert spare(Kept(h, 25.0, sure, ()), fit) > 0
    assert spare(Kept(h, 25.0, doubtful, ()), fit) == -4.0


def fitted_with(folder, names, **options):
    make_case(folder / "case", "hinge", options.pop("effects", ()), 61, seconds=10.0, **options)
    fit = nominal_fit(read(folder / "case")[0])
    fit = refit(fit, (*fit.model.hypotheses, *(Hypothesis(EFFECTS[name], at) for name, at in names)))
    return with_noise(fit, 1)


@pytest.mark.long
def test_no_clock_stays_in_a_fit_that_began_with_two(tmp_path):
    fit = fitted_with(tmp_path, [("time_offset", "imu1"), ("time_offset", "imu2")], encoder=True)
    begun = [Kept(h, np.inf, NOTHING, ()) for h in fit.model.hypotheses]
    left = moved(Drop(), fit, begun)
    assert len(begun) == len(left.dropped) == 2
    assert not left.kept and not left.fit.model.hypotheses


@pytest.mark.long
def test_a_filter_that_delays_by_nothing_is_dropped_as_worth_nothing(tmp_path):
    """Far above the motion its states are what they are driven by: the samples do not know its cutoff."""
    fit = fitted_with(tmp_path, [("low_pass", "imu2")])
    (h,) = fit.model.hypotheses
    assert not natural(fit, h)
    left = moved(Drop(), fit, [Kept(h, 40.0, NOTHING, ())])
    assert left.dropped == ((h, 0.0),)
    assert not left.kept and not left.fit.model.hypotheses


@pytest.mark.long
@pytest.mark.parametrize(("colour", "stays"), [(0.0, True), (0.2, False)])
def test_a_drift_that_the_noise_s_colour_may_be_is_none(tmp_path, colour, stays):
    """A drift that stands out of white noise: a fifth of coloured noise may be that."""
    drift = ("gyro_drift", "imu2", {"rate": [1.8e-4, 0.0, 0.0]})
    fit = fitted_with(tmp_path, [drift[:2]], effects=[drift], colour=colour)
    (h,) = fit.model.hypotheses
    white = about_zero(fit, [h], information(fit)[0])
    (k,) = in_colour(fit, [Kept(h, white, NOTHING, ())], *information(fit))
    assert white > 2 * EVIDENCE.needed_nat
    assert (k.evidence > EVIDENCE.needed_nat) is stays
    assert firmly(fit, [Kept(h, white, NOTHING, ())]) == ([h] if k.evidence > EVIDENCE.certain_nat else [])
    kept = moved(Drop(), fit, [Kept(h, white, NOTHING, ())], firm=(h,)).kept
    assert [k.hypothesis for k in kept] == [h]
    assert kept[0].evidence == white


@pytest.mark.parametrize(
    ("effect", "expected"), [("rocking_mount", 101.0), ("mount_shift", 30.0), ("joint_play", -98.0)]
)
def test_a_mount_that_is_not_worth_its_freedoms_is_asked_with_a_tighter_law(
    effect, expected, hardly_counting, monkeypatch
):
    """A rocking mount of 31 Hz at the floor of its law's noise, on the knots that its springs ask for."""
    fit = hardly_counting(300)
    tight = replace(fit, noise=dict(fit.noise))
    monkeypatch.setattr(prune_module, "refit_without", lambda fit, _, steps: fit)
    monkeypatch.setattr(prune_module, "tightened", lambda *_: tight)
    monkeypatch.setattr(prune_module, "aic_gain", lambda _, with_it: 101.0 if with_it is tight else -98.0)
    monkeypatch.setattr(prune_module, "evidence_over", lambda *_: 30.0)
    assert price_of_dropping(fit, Hypothesis(EFFECTS[effect], "imu2"))[0] == expected

"""Numbers that scale a motion nobody measured, against what the independent generator made."""

import numpy as np
import pytest

from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.looser_motion import with_looser_motion
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import converged
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

HAND = {"band": 1.17, "vigour": 1.287, "rest": 0.329, "gyro_noise": 0.005, "accel_noise": 0.0465, "rate": 200.0}


def slid(folder, at, seed, **options):
    """The converged fit of a hinge with skin that slides, its hypothesis, and its true numbers."""
    truth = make_case(folder, "hinge", [("skin_sliding", at)], seed, "strong", seconds=15.0, **(HAND | options))
    h = Hypothesis(EFFECTS["skin_sliding"], at)
    fit = converged(with_noise(refit(nominal_fit(read(folder)[0]), (h,))))
    return fit, h, truth["effects"][0]["parameters"]


def off(fit, h, truth):
    """Errors (6,) over their standard deviations."""
    std = parameter_std(fit)
    errors = [(fit.state.values[h.key(n)] - truth[n]) / std[h.key(n)] for n in ("slide", "twist")]
    return np.abs(np.concatenate(errors))


@pytest.mark.slow
@pytest.mark.parametrize(("at", "seed"), [("imu1", 6), ("imu2", 23)])
def test_a_twist_about_the_axis_is_not_taken_for_a_smaller_angle(tmp_path, at, seed):
    fit, h, truth = slid(tmp_path / "r", at, seed)
    assert off(fit, h, truth).max() > 3.0  # what it is for
    assert off(with_looser_motion(fit), h, truth).max() < 2.5


@pytest.mark.long
@pytest.mark.parametrize(
    ("effect", "encoder"), [("skin_sliding", True), ("accel_bias", False), ("skin_sliding", False)]
)
def test_only_a_motion_that_such_numbers_scale_is_held_looser(tmp_path, effect, encoder):
    make_case(tmp_path / "r", "hinge", [], 21, seconds=3.0, encoder=encoder)
    fit = nominal_fit(read(tmp_path / "r")[0])
    fit = extended(fit, (*fit.model.hypotheses, Hypothesis(EFFECTS[effect], "imu2")))
    changed = {n for n, std in with_looser_motion(fit).noise.items() if std != fit.noise[n]}
    hides = effect == "skin_sliding" and not encoder
    assert changed == ({"smooth.attitude", "smooth.hinge"} if hides else set())

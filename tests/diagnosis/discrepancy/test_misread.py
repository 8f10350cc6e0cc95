"""An encoder's zero and the error of its disc, in a swing on a fixed base: found, and no torque without a name."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.config.solve import MOTION_PRIOR
from imubench.diagnosis.discrepancy.term_scores import promising
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem import encoder_calibration
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.refit import information, refit
from imubench.effects import EFFECTS
from imubench.jets import Jet, variable

VISCOUS = {"viscous_friction": 1e-3}


def off(q):
    """Rad that the disc of these tests says beside the angle: a zero, an axle off its middle, an oval."""
    return 4e-3 + 1.2e-3 * np.sin(q - 0.4) + 3e-4 * np.cos(2 * q + 1.0)


def fitted(recording):
    return with_noise(refit(nominal_fit(recording), (Hypothesis(EFFECTS["viscous_friction"], "joint"),)))


def most_promising(fit):
    return max(g.white for g in promising(fit)[0])


def test_what_is_read_is_the_angle_beside_its_error_and_both_derivatives_are_exact():
    rng = np.random.default_rng(0)
    q, error = rng.normal(size=(5, 1)), 0.1 * rng.normal(size=encoder_calibration.spread().size)
    jet = encoder_calibration.read(variable(("q", 0), q), variable(("e", -1), error))
    by_hand = q[:, 0] + error[0]
    for k in range(1, MOTION_PRIOR.encoder_waves + 1):
        by_hand += error[2 * k - 1] * np.sin(k * q[:, 0]) + error[2 * k] * np.cos(k * q[:, 0])
    assert_allclose(jet.value[:, 0], by_hand, rtol=1e-12)
    step = 1e-6  # central differences of smooth functions: 1e-10 off

    def plain(q, error):
        return encoder_calibration.read(Jet(q), Jet(error[None])).value

    by_angle = (plain(q + step, error) - plain(q - step, error)) / (2 * step)
    assert_allclose(jet.blocks[("q", 0)][:, :, 0], by_angle, atol=1e-8)
    for i, one in enumerate(np.eye(error.size)):
        by_error = (plain(q, error + step * one) - plain(q, error - step * one)) / (2 * step)
        assert_allclose(jet.blocks[("e", -1)][:, 0, i], by_error[:, 0], atol=1e-8)


def test_only_a_swing_on_a_fixed_base_shows_it(swung):
    recording = swung(VISCOUS, seconds=3.0)
    assert encoder_calibration.misreads(recording)
    assert not encoder_calibration.misreads(replace(recording, free_swings=()))
    assert not encoder_calibration.misreads(replace(recording, body=None))
    assert not encoder_calibration.misreads(replace(recording, base="free"))


def test_a_disc_that_is_not_round_is_found_and_no_torque_is(swung, monkeypatch):
    recording = swung(VISCOUS, off=off)
    fit = fitted(recording)
    seen = np.linspace(*np.quantile(recording.encoders[0].angle, [0.05, 0.95]), 50)
    jet = encoder_calibration.read(Jet(seen[:, None]), variable(("e", -1), fit.state.values[encoder_calibration.ERROR]))
    columns = fit.model.parameters.columns(encoder_calibration.ERROR)
    covariance = information(fit)[0][columns, columns]
    std = np.sqrt(np.einsum("ni,ij,nj->n", jet.blocks[("e", -1)][:, 0], covariance, jet.blocks[("e", -1)][:, 0]))
    assert np.all(np.abs(jet.value[:, 0] - seen - off(seen)) < 3 * std)
    assert std.max() < 2e-4  # of an error that goes from 3 to 5 mrad
    c, std = (x["viscous_friction@joint.c"][0] for x in (fit.state.values, information(fit)[1]))
    assert abs(c - 1e-3) < 3 * std < 5e-5
    assert most_promising(fit) < 8.0  # of noise, of the four that are tried; 1 to 3 here
    monkeypatch.setattr("imubench.diagnosis.problem.batch_model.misreads", lambda recording: False)
    assert most_promising(fitted(recording)) > 100.0  # without it a torque of the joint's angle would be said


@pytest.mark.parametrize("seed", range(3))
def test_an_encoder_without_an_error_has_none(swung, seed):
    fit = fitted(swung(VISCOUS, seed=seed))
    std = information(fit)[1][encoder_calibration.ERROR]
    assert np.all(
        np.abs(fit.state.values[encoder_calibration.ERROR]) < 4 * std
    )  # 39 of them: 3.3 are to be expected once in 25

"""A hum that a fit believes in and the samples do not have: the motion would have to undo it."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.plausible_fit import unheard
from imubench.diagnosis.noise.nominal import first_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.drop import natural
from imubench.diagnosis.solve.initialize import model_of
from imubench.effects import EFFECTS
from imubench.format1 import read_recording
from imubench.proof.case import make_case

HUM = {"frequency": 17.0, "amplitude": [0.3, -0.2, 0.4]}


@pytest.fixture(scope="module")
def humming(tmp_path_factory):
    out = tmp_path_factory.mktemp("hum") / "case"
    make_case(out, "free", [("vibration", "imu1", HUM)], seed=3, seconds=12.0)
    return first_fit(model_of(read_recording(out)), 3)


def hum_of(fit, frequency):
    """The line that the samples have at a frequency, as a hum at imu1 in the fit."""
    h = Hypothesis(EFFECTS["vibration"], "imu1")
    model = fit.model.with_effects((h,))
    (imu,) = fit.model.recording.imus
    phase = 2 * np.pi * frequency * (imu.time - model.start)
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=1) * np.hanning(len(phase))[:, None]
    cosine, sine = waves.T @ (imu.accel - imu.accel.mean(axis=0)) * 2 / np.hanning(len(phase)).sum()
    values = {h.key("frequency"): np.array([frequency]), h.key("cosine"): cosine, h.key("sine"): sine}
    return h, replace(fit, model=model, state=replace(fit.state, values=fit.state.values | values))


def louder(fit, h, times):
    values = fit.state.values
    more = {h.key(name): times * values[h.key(name)] for name in ("cosine", "sine")}
    return replace(fit, state=replace(fit.state, values=values | more))


def test_a_hum_is_heard_as_loud_as_the_samples_have_it(humming):
    h, fit = hum_of(humming, HUM["frequency"])
    size = np.hypot(*(fit.state.values[h.key(name)] for name in ("cosine", "sine")))
    assert size == pytest.approx(np.abs(HUM["amplitude"]), rel=0.2)  # its phase wanders, which takes of a line
    assert not unheard(fit, h)
    assert natural(fit, h)


@pytest.mark.parametrize(("times", "heard"), [(0.5, True), (1.8, True), (2.2, False), (-1.0, False)])
def test_half_of_a_hum_has_to_be_in_the_samples_and_in_its_phase(humming, times, heard):
    h, fit = hum_of(humming, HUM["frequency"])
    assert unheard(louder(fit, h, times), h) is not heard


def test_a_hum_that_the_motion_undoes_is_none(humming):
    h, fit = hum_of(humming, HUM["frequency"])
    elsewhere = replace(fit, state=replace(fit.state, values=fit.state.values | {h.key("frequency"): np.array([23.0])}))
    assert unheard(elsewhere, h)
    assert not natural(elsewhere, h)


def test_what_is_no_hum_is_not_asked(humming):
    h = Hypothesis(EFFECTS["accel_bias"], "imu1")
    assert not unheard(replace(humming, model=humming.model.with_effects((h,))), h)

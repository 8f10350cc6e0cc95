"""Standard deviations under noise that is not white, on recordings of the independent generator."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.noise.coloured import influence, parameter_std
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import factored
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.marginals import Marginals
from imubench.diagnosis.solve.refit import information, refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

PUT_IN = (("accel_bias", "imu2"), ("gyro_scale", "imu1"))


def fitted(folder, seed, seconds, **options):
    """The fit that is told of both effects, those effects' keys, and their true values by key."""
    truth = make_case(folder / "r", "hinge", PUT_IN, seed, seconds=seconds, **options)
    recording = read(folder / "r")[0]
    effects = [Hypothesis(EFFECTS[name].suited(recording), at) for name, at in PUT_IN]
    fit = refit(nominal_fit(recording), tuple(effects))
    true = {
        h.key(p.name): np.ravel(e["parameters"][p.name])
        for h, e in zip(effects, truth["effects"], strict=True)
        for p in h.effect.parameters
        if p.reported
    }
    return with_noise(fit), true


@pytest.fixture(scope="module")
def white(tmp_path_factory):
    return fitted(tmp_path_factory.mktemp("white"), 11, 15.0)


@pytest.mark.long
def test_white_noise_leaves_the_standard_deviations_as_they_are(white):
    fit, true = white
    plain, found = information(fit)[1], parameter_std(fit)
    for key in true:
        assert found[key] == pytest.approx(plain[key], rel=0.3)  # bands of a few bins show the noise to some 20 %


@pytest.mark.slow
def test_the_influence_is_what_a_changed_sample_does_to_the_parameters(white):
    fit, _ = white
    rows = fit.rows
    _, solution, parts = factored(fit.model, rows)
    spread = Marginals.of(solution, fit.model.tracks.width)
    at = next(i for i, r in enumerate(rows) if r.name == "imu2.accel")
    wave = 0.02 * np.sin(2 * np.pi * 0.3 * rows[at].time)  # m/s^2
    recording = fit.model.recording
    imus = [replace(i, accel=i.accel + [[w, 0, 0] for w in wave]) if i.name == "imu2" else i for i in recording.imus]
    pushed = replace(fit.model, recording=replace(recording, imus=tuple(imus)))
    tight = {"enough": 1e-12, "steps": 20}
    before = solve(fit.model, fit.state, fit.noise, fit.anchor, **tight).state
    after = solve(pushed, fit.state, fit.noise, fit.anchor, **tight).state
    a = (
        influence(spread, parts[at])[:, 0]
        * (wave / np.broadcast_to(rows[at].std, rows[at].residual.value.shape)[:, 0])[:, None]
    )
    key = "accel_bias@imu2.bias"
    expected = a.sum(axis=0)[fit.model.parameters.columns(key)]
    moved = after.values[key] - before.values[key]
    assert moved == pytest.approx(expected, abs=0.02 * np.abs(expected).max())  # the fit is not quite linear


@pytest.mark.slow
def test_errors_are_of_the_size_that_is_stated(tmp_path):
    as_white, stated = [], []
    for seed in range(40, 52):
        (tmp_path / str(seed)).mkdir()
        fit, true = fitted(tmp_path / str(seed), seed, 20.0, colour=0.2)
        plain, found = information(fit)[1], parameter_std(fit)
        for key, value in true.items():
            error = fit.state.values[key] - value
            as_white.append(error / plain[key])
            stated.append(error / found[key])
    assert np.sqrt(np.mean(np.square(as_white))) > 1.4
    assert 0.75 < np.sqrt(np.mean(np.square(stated))) < 1.3  # 72 numbers, three of a recording go together

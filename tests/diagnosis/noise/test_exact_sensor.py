"""No sensor is taken for exact, and a number is never known worse than its prior says."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.samples.rest_noise import LEAST_REST_STD, least_noise
from imubench.diagnosis.sensor_errors.own_errors import own_errors
from imubench.diagnosis.solve.gauss_newton import all_rows, factored
from imubench.diagnosis.solve.marginals import covariance_of
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    folder = tmp_path_factory.mktemp("exact") / "r"
    make_case(folder, "hinge", [], 2, seconds=5.0, rate=50.0, declare_noise=False)
    return nominal_fit(read(folder)[0])


def test_the_model_knows_what_an_imu_has_at_least(plain):
    assert plain.model.least == least_noise(plain.model.recording)
    assert set(plain.model.least.values()) == set(
        LEAST_REST_STD.values()
    )  # a hand moves it: its quietest moments are louder


def test_a_simulated_sensor_may_have_less(plain):
    still = tuple(
        replace(imu, gyro=0 * imu.gyro + 0.1, accel=0 * imu.accel + 9.81) for imu in plain.model.recording.imus
    )
    least = least_noise(replace(plain.model.recording, imus=still))
    assert all(std < 1e-6 for std in least.values())


def test_undeclared_noise_stays_above_it(plain):
    loud = {name: 1000 * std for name, std in plain.model.least.items()}
    noise = with_noise(replace(plain, model=replace(plain.model, least=loud))).noise
    assert all(noise[name] == std for name, std in loud.items())


def test_undeclared_noise_of_a_clean_recording_is_its_own(plain):
    free = with_noise(replace(plain, model=replace(plain.model, least={}))).noise
    held = with_noise(plain).noise
    assert all(held[name] == free[name] for name in plain.model.least)


def test_the_covariance_is_the_inverse_where_rounding_is_small(plain):
    _, solution, _ = factored(plain.model, plain.rows)
    assert_allclose(covariance_of(plain.model, solution.schur), np.linalg.inv(solution.schur), rtol=1e-6)  # rounding


def test_a_number_is_known_at_least_as_its_prior_says(plain):
    std = np.concatenate([p.std for p in plain.model.priors.values()])
    lost = np.diag(1 / std**2)
    lost[0, 0] *= -1.5  # what rounding may leave of a small difference of large numbers
    assert_allclose(np.sqrt(np.diag(covariance_of(plain.model, lost))), std, rtol=1e-12)  # rounding


def test_every_error_has_finite_numbers_though_a_sensor_is_nearly_exact(plain):
    noise = plain.noise | {"imu2.accel": 1e-7}
    exact = replace(plain, noise=noise, rows=all_rows(plain.model, plain.state, noise, plain.anchor))
    for sensor in own_errors(exact, exact.model.recording.imus):
        for own in sensor.errors:
            for parameter in own.parameters.values():
                assert np.all(np.isfinite(parameter.std))
                assert np.all(parameter.std > 0)

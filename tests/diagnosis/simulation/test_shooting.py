"""Numbers that roll-outs show, beside those that the generator of a free swing had."""

from dataclasses import replace

import numpy as np
import pytest

from imubench import rotations
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.simulation import rolled_numbers
from imubench.diagnosis.simulation.beside import beside
from imubench.diagnosis.simulation.learned import numbers_of
from imubench.diagnosis.simulation.rolled_numbers import can_shoot
from imubench.diagnosis.simulation.shooting import at_numbers, known_outside
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.sim.swing import Start

SECONDS = 12.0


@pytest.fixture(scope="module")
def swung(tmp_path_factory):
    """A limb that swings free, without any effect, its mount declared to a degree or two; and where that is."""
    folder = tmp_path_factory.mktemp("swung") / "r"
    case = make_case(folder, "pendulum", [], 5, swing=True, seconds=SECONDS)
    return read(folder)[0], case


@pytest.fixture(scope="module")
def judged(swung):
    recording, _ = swung
    fit = nominal_fit(recording)
    (imu,) = recording.imus
    noise = {"imu1.gyro": imu.gyro_noise_std, "imu1.accel": imu.accel_noise_std}
    return fit, beside(recording, fit, fit, noise, {})


def off_by(fit, case):
    """How far the mount of a fit is turned from the generator's, rad."""
    base = fit.model.mounts["imu1"].turn
    turned = base @ rotations.to_matrix(rotations.exp(fit.state.values["imu1.rotation"]))
    true = rotations.to_matrix(np.asarray(case["mounts"][0]["quaternion"]))
    return float(np.linalg.norm(rotations.log(rotations.from_matrix(true.T @ turned))))


@pytest.mark.long
def test_roll_outs_know_a_mount_better_than_the_equation_between_knots_does(swung, judged):
    fit, found = judged
    assert found.numbers is not None
    assert off_by(found.numbers, swung[1]) < 0.3 * off_by(fit, swung[1])


@pytest.mark.long
def test_a_right_model_is_rolled_out_to_the_noise_with_numbers_from_the_other_half(judged):
    _, found = judged
    assert found.simulation.how == "rolled out" and found.simulation.heldout
    misfit = np.mean([(c.after / c.noise) ** 2 for c in found.simulation.channels.values()])
    assert misfit < 1.1 * 1.15**2 * 1.2  # the noise is declared to 15 %, a fifth of it may be coloured


def test_samples_outside_of_windows_know_less_than_all(swung):
    fit = nominal_fit(swung[0])

    def known(*windows):
        return known_outside(fit, lambda time: np.ones(time.size, dtype=bool), windows)

    (window,) = (Swing(*span, Start()) for span in swung[0].free_swings)
    least, most = (np.linalg.eigvalsh(known(*w).information)[-1] for w in ((window,), ()))
    assert least < 0.5 * most  # the swing is most of the recording
    np.testing.assert_allclose(known().numbers, numbers_of(fit), atol=1e-5)  # nothing moves a fit at its own best


def test_a_fit_at_its_own_numbers_is_itself(swung):
    fit = nominal_fit(swung[0])
    again = at_numbers(fit, numbers_of(fit))
    assert all(np.array_equal(again.state.values[k], v) for k, v in fit.state.values.items())


def test_a_sensor_that_slips_keeps_the_numbers_of_the_motion_fit(swung):
    fit = nominal_fit(swung[0])
    assert can_shoot(fit)
    slipped = refit(fit, (Hypothesis(EFFECTS["mount_shift"], "imu1"),))
    assert not can_shoot(slipped)


@pytest.mark.long
def test_a_limb_that_is_far_off_teaches_nothing(judged, monkeypatch, swung):
    fit, _ = judged
    monkeypatch.setattr(rolled_numbers, "ROLL_OUT", replace(ROLL_OUT, near=0.1))  # of the noise: none is so near
    (imu,) = swung[0].imus
    noise = {"imu1.gyro": imu.gyro_noise_std, "imu1.accel": imu.accel_noise_std}
    assert beside(swung[0], fit, fit, noise, {}).numbers is None

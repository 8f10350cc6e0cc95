"""Numbers that roll-outs show, beside those that the generator of a free swing had."""

from dataclasses import replace

import numpy as np
import pytest

from imubench import rotations
from imubench.diagnosis.config.noise import DEBIAS
from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.simulation import roll_outs, rolled_numbers
from imubench.diagnosis.simulation.beside import beside
from imubench.diagnosis.simulation.channels import judged_channels
from imubench.diagnosis.simulation.judge import Judge, counting, rolled
from imubench.diagnosis.simulation.learned import Part, numbers_of
from imubench.diagnosis.simulation.rolled_numbers import can_shoot
from imubench.diagnosis.simulation.shooting import Shooting, at_numbers, known_outside
from imubench.diagnosis.simulation.sim_model import SimModel, sim_model
from imubench.diagnosis.simulation.splice import rolled_truth
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case
from imubench.sim.rigs import Mount, hinge
from imubench.sim.swing import Start

SECONDS = 12.0


@pytest.fixture(scope="module")
def limb(tmp_path_factory):
    """A limb that swings free, without any effect, its mount declared to a degree or two; and where that is."""
    folder = tmp_path_factory.mktemp("limb") / "r"
    case = make_case(folder, "pendulum", [], 5, swing=True, seconds=SECONDS)
    return read(folder)[0], case


@pytest.fixture(scope="module")
def judged(limb):
    recording, _ = limb
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
def test_roll_outs_know_a_mount_better_than_the_equation_between_knots_does(limb, judged):
    fit, found = judged
    assert found.numbers is not None
    assert off_by(found.numbers, limb[1]) < 0.3 * off_by(fit, limb[1])


@pytest.mark.long
def test_a_right_model_is_rolled_out_to_the_noise_with_numbers_from_the_other_half(judged):
    _, found = judged
    assert found.simulation.how == "rolled out" and found.simulation.heldout
    misfit = np.mean([(c.after / c.noise) ** 2 for c in found.simulation.channels.values()])
    assert misfit < 1.1 * 1.15**2 * 1.2  # the noise is declared to 15 %, a fifth of it may be coloured


def test_samples_outside_of_windows_know_less_than_all(limb):
    fit = nominal_fit(limb[0])

    def known(*windows):
        return known_outside(fit, lambda time: np.ones(time.size, dtype=bool), windows)

    (window,) = (Swing(*span, Start()) for span in limb[0].free_swings)
    least, most = (np.linalg.eigvalsh(known(*w).information)[-1] for w in ((window,), ()))
    assert least < 0.5 * most  # the swing is most of the recording
    np.testing.assert_allclose(known().numbers, numbers_of(fit), atol=1e-5)  # nothing moves a fit at its own best


def test_a_fit_at_its_own_numbers_is_itself(limb):
    fit = nominal_fit(limb[0])
    again = at_numbers(fit, numbers_of(fit))
    assert all(np.array_equal(again.state.values[k], v) for k, v in fit.state.values.items())


def test_a_sensor_that_slips_keeps_the_numbers_of_the_motion_fit(limb):
    fit = nominal_fit(limb[0])
    assert can_shoot(fit)
    slipped = refit(fit, (Hypothesis(EFFECTS["mount_shift"], "imu1"),))
    assert not can_shoot(slipped)


@pytest.mark.long
def test_a_limb_that_is_far_off_teaches_nothing(judged, monkeypatch, limb):
    fit, _ = judged
    monkeypatch.setattr(rolled_numbers, "ROLL_OUT", replace(ROLL_OUT, near=0.1))  # of the noise: none is so near
    (imu,) = limb[0].imus
    noise = {"imu1.gyro": imu.gyro_noise_std, "imu1.accel": imu.accel_noise_std}
    assert beside(limb[0], fit, fit, noise, {}).numbers is None


@pytest.fixture(scope="module")
def dry(swung_arm):
    """Roll-outs of an arm with dry friction and drag beside an encoder whose error is learned, near their best."""
    fit = refit(
        nominal_fit(swung_arm), tuple(Hypothesis(EFFECTS[name], "joint") for name in ("dry_friction", "air_drag"))
    )
    noise = {"encoder.angle": 4e-5}
    measured = judged_channels(swung_arm, noise)
    part = Part(*swung_arm.free_swings[0], 0, True)
    judge = Judge(swung_arm, measured, counting(measured, fit), noise, (part,), ((), ()))
    windows = rolled(judge, fit, sim_model(fit), (part,))
    known = known_outside(fit, lambda time: np.ones(time.size, dtype=bool), windows)
    return Shooting(fit, known, judge.misfit, np.ones(fit.model.parameters.count, dtype=bool)), windows


@pytest.fixture(scope="module")
def swung_arm(request):
    return request.getfixturevalue("swung")({"dry_friction": 0.02, "air_drag": 5e-4}, 5.0)


def test_slopes_are_central_differences_of_another_length(dry):
    shooting, windows = dry
    here = shooting.at(numbers_of(shooting.fit), windows)
    slopes, (window,) = shooting.slopes(here), windows

    def off(numbers, angle=0.0):
        state = replace(window.state, angle=window.state.angle + angle)
        return shooting.at(here.numbers + numbers, [replace(window, state=state)]).off[0]

    still = np.zeros(here.numbers.size)
    for i in (0, 2, still.size - 2, still.size - 1):  # the encoder's zero and a wave, friction, drag
        reach = 1e-5 * (np.arange(still.size) == i)
        by = (off(reach) - off(-reach)) / 2e-5
        np.testing.assert_allclose(slopes.numbers[0][:, i], by, atol=2e-3 * np.abs(by).max())
    by = (off(still, 1e-5) - off(still, -1e-5)) / 2e-5
    np.testing.assert_allclose(slopes.state[0][:, 0], by, atol=1e-3 * np.abs(by).max())


def test_a_step_gains_what_it_promises_and_the_last_one_moves_nothing(dry):
    shooting, windows = dry
    here = shooting.at(numbers_of(shooting.fit), windows)
    step = shooting.step(here, shooting.slopes(here))
    gain = here.cost - shooting.along(here, step).cost
    assert gain == pytest.approx(step.promised, rel=0.1)  # from numbers that a motion fit has, next to linear
    best = shooting.learned(windows)
    last = shooting.step(best, shooting.slopes(best))
    n = best.off[0].size
    assert last.promised <= 2 * DEBIAS.settled**2 * best.cost / n  # its derivatives are a standard deviation old
    assert best.cost / n == pytest.approx(1.0, abs=5 * np.sqrt(2 / n))  # the noise is known


def test_what_does_not_move_the_rig_is_not_integrated_again(dry, monkeypatch):
    shooting, windows = dry
    made = []
    real = roll_outs.rolled_out
    monkeypatch.setattr(roll_outs, "rolled_out", lambda *a, **k: made.append(a) or real(*a, **k))
    judge = replace(shooting.misfits.__self__, roll_outs=roll_outs.RollOuts(200.0, 2.5e-3))
    shooting = replace(shooting, misfits=judge.misfit)
    here = shooting.at(numbers_of(shooting.fit), windows)
    made.clear()
    shooting.slopes(here)
    assert len(made) == 4  # angle and rate at the start, friction and drag; thirteen of the encoder need none


def test_a_mount_moves_no_roll_out_and_is_played_anew():
    at = Mount(np.array([0.1, 0.0, 0.02]))
    arms = [replace(hinge(base="fixed", dry_friction=0.02), mounts=(Mount(), m)) for m in (at, Mount(at.position * 2))]
    window, rolls = Swing(0.0, 2.0, Start(angle=1.0)), roll_outs.RollOuts(100.0, 5e-3)
    models = [SimModel(arm, (), 0.0) for arm in arms]
    near, far = (rolls.truth(m, window) for m in models)
    assert len(rolls.motions.made) == 1 and len(rolls.truths.made) == 2
    assert np.abs(near.sensor("imu2").specific_force - far.sensor("imu2").specific_force).max() > 0.1
    alone = rolled_truth(arms[1], window, 100.0, 0.0, step=5e-3)  # its sensors have a billionth of the weight
    np.testing.assert_allclose(far.sensor("imu2").specific_force, alone.sensor("imu2").specific_force, atol=1e-6)
    np.testing.assert_allclose(
        rolls.truth(models[0], window, angle_alone=True).joint_angle, alone.joint_angle, atol=1e-7
    )


def test_what_was_made_long_ago_is_made_again():
    latest, made = roll_outs.Latest(), []
    for key in (0, 1, 0, 2, 1, 0):  # 400,000 numbers each: two of them stay, those asked for last
        latest.of(key, lambda key=key: made.append(key) or np.zeros(400_000))
    assert made == [0, 1, 2, 1, 0]

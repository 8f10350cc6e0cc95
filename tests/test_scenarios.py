"""Scenarios by name, the motions and sequences of Olsson et al. among them, and what a run may change of them."""

import json

import numpy as np
import pytest

from imubench.dataset.effect_text import effect_from_text
from imubench.errors import InputError
from imubench.run import Changes, simulate
from imubench.scenarios import SCENARIOS
from imubench.scenarios.olsson2020.motions import MOTIONS
from imubench.scenarios.olsson2020.plan import SEQUENCES
from imubench.scenarios.olsson2020.sequences import assemble
from imubench.score import axis_deviation
from imubench.sim.injected import all_injectable
from tests.command import here


def changed(scenario: str, *effects: str, seed: int = 1, **more: object):
    changes = Changes(effects=tuple(effect_from_text(text) for text in effects), **more)
    return simulate(scenario, seed, changes)


def test_every_motion_and_sequence_has_a_name():
    names = {f"olsson2020/motion-{n}" for n in MOTIONS} | {f"olsson2020/sequence-{n}" for n in (1, 2, 3, 4)}
    assert names <= set(SCENARIOS)
    assert len(SEQUENCES) == 4
    for name, scenario in SCENARIOS.items():
        assert name == scenario.name
        assert scenario.summary
        assert scenario.seconds >= 10, name  # what any of them needs to show anything


def test_a_motion_is_as_long_as_it_is_asked_to_be_and_begins_at_zero():
    recording, truth = changed("olsson2020/motion-11", seconds=12.0)
    assert recording.name == "olsson2020-motion-11-1"
    assert recording.imus[0].time[0] == 0.0
    assert recording.imus[0].time.size == 12 * 50  # samples of the MTw, 50 Hz
    assert truth.time[-1] == pytest.approx(12.0 - 1e-3)  # one step of 1 ms before its end
    resting = np.linalg.norm(truth.segments[1].rate, axis=1) < 1e-9  # motion 4, fast: one segment at rest at a time
    assert 0.3 < resting.mean() < 0.6


def test_a_sequence_is_that_of_a_session_and_its_truth_goes_with_it():
    recording, truth = simulate("olsson2020/sequence-3", 2)
    ours = assemble("sequence3", 2)
    np.testing.assert_array_equal(recording.imus[1].gyro, ours.recording.imus[1].gyro)
    assert recording.imus[0].time.size == truth.time.size == round(SCENARIOS["olsson2020/sequence-3"].seconds * 50)
    assert [label[1:] for label in truth.labels] == [(s.start, s.end) for s in ours.sections]
    for imu, sensor in zip(recording.imus, truth.sensors, strict=True):  # bias taken off, and what is left of it
        np.testing.assert_allclose(imu.time, truth.time, atol=1e-9)  # rounding of stamps
        off = imu.gyro - sensor.gyro
        assert np.sqrt(np.mean(off**2)) < 0.02  # rad/s; noise of 0.004 and 1 % of scale at 2 rad/s, and no other piece
    axes = np.stack([s.joint_axis.mean(axis=0) for s in truth.sensors])
    assert axis_deviation(axes, ours.axes).max() < 1e-9  # rounding: the mounts are rigid


@pytest.mark.parametrize("what", ["duration", "effects"])
def test_a_sequence_takes_another_imu_and_nothing_else(what):
    effects, changes = (["gravity:g=9.7"], {}) if what == "effects" else ([], {"seconds": 20.0})
    with pytest.raises(InputError, match=f"olsson2020/sequence-3: expected no {what} beside its own"):
        changed("olsson2020/sequence-3", *effects, **changes)
    assert changed("olsson2020/sequence-3", imu="perfect")[0].imus[0].gyro_noise_std in (None, 0.0)


def test_an_effect_comes_on_top_and_leaves_every_other_draw_alone():
    plain, _ = simulate("hinge-hand", 1)
    biased, _ = changed("hinge-hand", "gyro_bias@imu2:bias=0.05")
    np.testing.assert_array_equal(biased.imus[0].gyro, plain.imus[0].gyro)
    np.testing.assert_array_equal(biased.imus[1].accel, plain.imus[1].accel)
    np.testing.assert_allclose(biased.imus[1].gyro - plain.imus[1].gyro, 0.05, atol=1e-3)  # rad/s; but for scale errors
    for one, other in zip(plain.imus, biased.imus, strict=True):  # nobody tells the owner
        assert one.gyro_noise_std == pytest.approx(other.gyro_noise_std)
        np.testing.assert_array_equal(one.mount_quaternion, other.mount_quaternion)


def test_a_mount_that_moves_is_declared_where_it_was():
    plain, before = simulate("hinge-hand", 1)
    moved, after = changed("hinge-hand", "mount_pose@imu1:rotation=0.1,translation=0")
    np.testing.assert_array_equal(plain.imus[0].mount_quaternion, moved.imus[0].mount_quaternion)
    np.testing.assert_array_equal(before.sensors[1].gyro, after.sensors[1].gyro)
    off = axis_deviation(*(np.stack([s.joint_axis[0] for s in truth.sensors]) for truth in (before, after)))
    assert 0.02 < off[0] < 0.3  # rad: 0.17 in all, and the 0.02 by which the owner measures
    assert off[1] == 0.0


def test_what_is_left_open_is_drawn_with_the_seed():
    one, same, other = (changed("hinge-hand", "gyro_bias@imu2:bias=0.1..0.9", seed=s)[0] for s in (1, 1, 2))
    assert np.array_equal(one.imus[1].gyro, same.imus[1].gyro)
    mean = [np.abs(r.imus[1].gyro.mean(axis=0)) for r in (one, other)]
    assert (mean[0] > 0.05).all()  # rad/s: a hand turns back and forth, a bias stays
    assert not np.allclose(*mean, atol=0.01)


FOR_IT = {"inertia", "viscous_friction", "dry_friction", "air_drag", "joint_spring"}
NEEDS = {
    "low_pass": "cutoff=8",
    "saturation": "limit=3,channels=gyro",
    "quantisation": "step=0.1,channels=accel",
    "gyro_noise": "std=0.05",
    "accel_noise": "std=0.5",
    "dropouts": "fraction=0.2",
    "joint_play": "range=0.03,direction=0",
    "impacts": "count=4",
    "vibration": "frequency=11,amplitude=0.5",
    "moving_pivot": "std=1,band=0.5..3",
}


@pytest.mark.long
@pytest.mark.parametrize("name", sorted(set(all_injectable()) - {"backlash", "end_stop"}))
def test_every_effect_that_can_be_played_changes_a_run(name):
    scenario = "hinge-swing" if name in FOR_IT else "pendulum-rigid" if name == "moving_pivot" else "hinge-hand"
    text = f"{name}:{NEEDS[name]}" if name in NEEDS else name
    plain, other = simulate(scenario, 1)[0], changed(scenario, text)[0]
    same = [np.array_equal(a, b) for a, b in zip(arrays(plain), arrays(other), strict=True)]
    assert not all(same), text


def arrays(recording):
    read = [a for imu in recording.imus for a in (imu.time, imu.gyro, imu.accel)]
    return [*read, *([] if recording.body is None else [recording.body.inertia])]


@pytest.mark.parametrize(
    ("scenario", "effect", "message"),
    [
        (
            "hinge-hand",
            "dry_friction:t=0.1",
            "hinge-hand: expected an effect that can be played in it, got dry_friction",
        ),
        ("hinge-swing", "end_stop:angle=1", "hinge-swing: expected an effect that can be played in it, got end_stop"),
        ("hinge-swing", "backlash:range=0.1", "hinge-swing: expected an effect that can be played in it, got backlash"),
        (
            "pendulum-rigid",
            "axis_coupling:coupling=0.1",
            "expected an effect that can be played in it, got axis_coupling",
        ),
        ("pendulum-gait", "moving_pivot:std=1,band=1..2", "pendulum-gait: expected another effect than moving_pivot"),
        ("hinge-hand", "soft_mont", "unknown --effect soft_mont.name 'soft_mont'; .*did you mean 'soft_mount'"),
        ("hinge-hand", "soft_mount@imu3", "unknown --effect soft_mount.at 'imu3'; known: imu1, imu2"),
        ("hinge-hand", "soft_mount:freq=3", "unknown key in --effect soft_mount 'freq'"),
        ("hinge-hand", "soft_mount:frequency", r"expected NAME@PLACE:KEY=VALUE,\.\.\., got 'frequency'; one VALUE"),
        (
            "hinge-hand",
            "soft_mount:frequency=3,frequency=4",
            "expected each number of the effect once, got 'frequency'",
        ),
        ("hinge-hand", "soft_mount:frequency=nine", "soft_mount.frequency: expected a number"),
        ("hinge-hand", "soft_mount:frequency=0.01", "soft_mount.frequency: expected numbers >= 0.5"),
        ("hinge-hand", "", "unknown --effect"),
    ],
)
def test_an_effect_that_cannot_be_is_one_line(scenario, effect, message):
    with pytest.raises(InputError, match=message):
        changed(scenario, effect)


def test_the_same_effect_comes_once_at_one_place():
    with pytest.raises(InputError, match="effect: expected gyro_bias imu2 once, got it twice"):
        changed("hinge-hand", "gyro_bias@imu2:bias=0.1", "gyro_bias:bias=0.2")


@pytest.mark.long
def test_run_plays_a_motion_with_another_imu_for_another_time_with_effects(tmp_path):
    words = ("--profile", "mpu9250", "--duration", "15", "--effect", "soft_mount@imu2:frequency=9,damping_ratio=0.1")
    done = here("run", "olsson2020/motion-11", *words, "--out", tmp_path / "out")
    assert done.code == 0, done.err
    score = json.loads((tmp_path / "out" / "score.json").read_text())
    numbers = {"frequency": [9.0] * 3, "damping_ratio": 0.1}
    effects = [{"effect": "soft_mount", "at": "imu2", "parameters": numbers}]
    assert score["changes"] == {"profile": "mpu9250", "duration": 15.0, "effects": effects}

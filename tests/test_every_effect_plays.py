"""The table effect x rig of docs/effects.md: concealed by the independent generator, true numbers played by MuJoCo."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imubench import rotations
from imubench.correction.read_model import read_model
from imubench.correction.replay import truth_of_motion
from imubench.correction.sensor_chain import read_by
from imubench.diagnosis.simulation.model_folder import replay
from imubench.effect_table import DOORS, OTHERWISE, cells, page
from imubench.effects import EFFECTS
from imubench.sim.injected import all_injectable
from tests.concealed import concealed, left, rms, rolled

PAGE = Path(__file__).resolve().parent.parent / "docs" / "effects.md"
NOISE = 1.1  # of the noise: what may be left. 1000 samples tell it to 2 %, and the motion is told by splines
ALL = {check: [(c.effect, c.rig) for c in cells() if c.check == check] for check in ("samples", "swing", "numbers")}
SIZES = {"accel_drift": {"rate": [0.03, -0.02, 0.03]}, "clock_skew": {"skew": 0.002}}
"""Of what is drawn too small to show in so short a recording."""


def place(effect: str, rig: str) -> str:
    kind = EFFECTS[effect].place
    return kind if kind != "imu" else "imu2" if rig == "hinge" else "imu1"


def both(tmp_path, effect: str, rig: str, **options):
    """A case's model with the effect in it, and the model of the same case without."""
    parameters = SIZES.get(effect)
    asked = [(effect, place(effect, rig), parameters)]
    told = concealed(tmp_path / "with", rig, asked, **options)
    return told, concealed(tmp_path / "without", rig, asked, told=(), **options)


def test_every_effect_goes_through_every_door():
    assert set(all_injectable()) == set(EFFECTS)
    assert {c.effect: c.doors for c in cells() if not c.whole} == {}
    assert {c.rig for c in cells()} == {"hinge", "pendulum", "free"}
    assert DOORS == ("sim", "dataset", "model")
    assert set(OTHERWISE) <= set(EFFECTS)


def test_the_page_is_what_the_code_says():
    assert PAGE.read_text(encoding="utf-8") == page(), "run python scripts/effect_table.py"


@pytest.mark.parametrize(("effect", "rig"), ALL["samples"])
def test_what_is_left_of_every_sample_is_noise(effect, rig, tmp_path):
    pose = True if effect == "gravity" and rig == "hinge" else None  # without, a hand's acceleration is as good
    options = {"seconds": 8.0, "encoder": effect == "backlash", "pose": pose}
    told, without = both(tmp_path, effect, rig, **options)
    after, before = left(told), left(without)
    assert max(after.values()) < NOISE, after
    assert max(before.values()) > 1.25, before  # else it showed nothing


@pytest.mark.long
@pytest.mark.parametrize(("effect", "rig"), ALL["swing"])
def test_what_is_left_of_a_roll_out_is_noise(effect, rig, tmp_path):
    options = {"seconds": 10.0, "swing": True, "base": "fixed" if rig == "hinge" else "free"}
    variant = "conservative" if effect == "joint_spring" and rig == "pendulum" else ""  # as the generator has it
    off = []
    for case in both(tmp_path, effect, rig, variant=variant, strength="medium", **options):
        # A limb on a ball joint is soon chaotic: the six digits of the MJCF file are seen after some seconds.
        measured, played, _ = rolled(case, 3.0 if rig == "hinge" else 2.0)
        off.append(rms((measured - played) / case.recording.imus[-1].gyro_noise_std))
    assert off[0] < NOISE and off[1] > 5.0, off


@pytest.mark.parametrize(("effect", "rig"), [c for c in ALL["numbers"] if c[0] in ("gyro_noise", "accel_noise")])
def test_noise_is_as_loud_as_measured(effect, rig, tmp_path):
    told, _ = both(tmp_path, effect, rig, seconds=8.0)
    kind, name = effect.split("_")[0], place(effect, rig)
    model, truth, imu = told.model(), told.truth(), told.recording.imu(name)
    played = []
    for rng in (np.random.default_rng(0), None):
        _, gyro, accel = read_by(truth, model.start, imu.time, name, model.chain(name), (0, 0), rng)
        played.append(gyro if kind == "gyro" else accel)
    loud = rms(played[0] - played[1])
    assert loud == pytest.approx(rms((getattr(imu, kind) - played[1])[100:]), rel=0.1)  # 2000 numbers: 2 % each
    assert loud > 1.5 * getattr(imu, f"{kind}_noise_std")


@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_rounded_samples_are_on_the_same_steps(rig, tmp_path):
    told, _ = both(tmp_path, "quantisation", rig, seconds=8.0)
    (effect,) = told.case.effects
    step, (channel,), name = effect.parameters["step"], effect.parameters["channels"], effect.at
    imu, recording = told.recording.imu(name), replay(told.folder, np.random.default_rng(0))[0]
    for samples in (getattr(imu, channel), getattr(recording.imu(name), channel)):
        assert np.abs(samples / step - np.round(samples / step)).max() < 1e-3  # digits of the file
    noise = getattr(imu, f"{channel}_noise_std")
    # Measured is rounded, and so is what is played: step^2 / 12 of each, and the noise.
    assert left(told)[f"{name}.{channel}"] * noise < NOISE * np.sqrt(noise**2 + step**2 / 6)


@pytest.mark.parametrize("mode", ["missing", "held"])
@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_as_many_samples_are_lost(rig, mode, tmp_path):
    name = place("dropouts", rig)
    told = concealed(tmp_path, rig, [("dropouts", name, {"fraction": 0.25, "mode": mode})])
    measured, played = told.recording.imu(name), replay(told.folder, np.random.default_rng(0))[0].imu(name)
    shares = []
    for imu in (measured, played):
        held = (np.diff(imu.gyro, axis=0) == 0).all(axis=1).mean()
        shares.append(held if mode == "held" else 1 - imu.time.size / ((imu.time[-1] - imu.time[0]) * 100))
    assert shares == pytest.approx([0.25, 0.25], abs=0.05)  # of 1000 samples: 0.014 each


@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_a_hum_is_as_loud_at_the_same_frequency(rig, tmp_path):
    told, without = both(tmp_path, "vibration", rig)
    (effect,) = told.case.effects
    frequency, name = effect.parameters["frequency"], effect.at
    model, plain, truth = told.model(), without.model(), told.truth()
    imu = told.recording.imu(name)
    quiet = read_by(truth, model.start, imu.time, name, plain.chain(name))[2]
    played = read_by(truth, model.start, imu.time, name, model.chain(name), (0, 0), np.random.default_rng(3))[2]
    turn = np.exp(-2j * np.pi * frequency * imu.time)[:, None] * np.hanning(imu.time.size)[:, None]
    measured, given = (
        np.abs(np.sum(x * turn, axis=0)) / np.sum(np.abs(turn)) * 2 for x in (imu.accel - quiet, played - quiet)
    )
    assert given == pytest.approx(np.abs(effect.parameters["amplitude"]), rel=0.02)  # what leaks out of the window
    assert measured == pytest.approx(given, rel=0.15)  # the generator's phase wanders by 0.05 rad per root second


@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_there_is_a_knock_at_each_time(rig, tmp_path):
    told, _ = both(tmp_path, "impacts", rig)
    (effect,) = told.case.effects
    model, truth, imu = told.model(), told.truth(), told.recording.imu(effect.at)
    quiet = read_by(truth, model.start, imu.time, effect.at, model.chain(effect.at))[2]
    struck = read_by(truth, model.start, imu.time, effect.at, model.chain(effect.at), (0, 0), np.random.default_rng(0))[
        2
    ]
    shaken = [np.linalg.norm(x - quiet, axis=1) > 5.0 for x in (imu.accel, struck)]  # m/s^2, a sixth of a knock
    for time in np.atleast_1d(effect.parameters["times"]):
        near = (imu.time > time) & (imu.time < time + 0.04)
        assert all(own[near].any() for own in shaken)
    far = np.all([np.abs(imu.time - t - 0.1) > 0.15 for t in np.atleast_1d(effect.parameters["times"])], axis=0)
    assert not any(own[far].any() for own in shaken)


@pytest.mark.parametrize("kind", ["free", "springy"])
def test_a_limb_plays_as_it_was_recovered(kind, tmp_path):
    effect = ("joint_play", "joint", {"range": 0.03, "direction": 0.7, "kind": kind})
    told = concealed(tmp_path / "with", "hinge", [effect], variant="wobbly")
    assert max(left(told).values()) < NOISE
    assert max(left(concealed(tmp_path / "without", "hinge", [effect], told=())).values()) > 10


@pytest.mark.long
def test_a_limb_of_which_two_numbers_are_told_falls_between_the_same_stops(tmp_path):
    effect = ("joint_play", "joint", {"range": 0.03, "direction": 0.7, "kind": "free"})
    told = concealed(tmp_path, "hinge", [effect], variant="wobbly")
    model = read_model(told.folder)
    assert model.rig.loose is not None and model.rig.loose.range == pytest.approx(0.03, rel=1e-4)
    motion = replace(model.motion, fitted=(), play=None)
    truth = truth_of_motion(model.rig, motion, model.start, 8.0, 100.0)
    half = truth.joint_angle / 2
    about_y = np.stack([np.cos(half), 0 * half, np.sin(half), 0 * half], axis=1)
    relative = rotations.multiply(rotations.conjugate(truth.segments[0].quaternion), truth.segments[1].quaternion)
    phi = rotations.log(rotations.multiply(rotations.conjugate(about_y), relative)) @ model.rig.loose.axis
    assert 0.03 < np.abs(phi).max() < 0.045  # a stop gives way by what a limb that falls through 60 mrad has
    assert np.quantile(np.abs(phi), 0.5) > 0.025  # mostly it leans on one


@pytest.mark.long
@pytest.mark.parametrize("rig", ["hinge", "pendulum"])
def test_a_limb_turns_round_at_its_stop(rig, tmp_path):
    options = {"seconds": 10.0, "swing": True, "base": "fixed" if rig == "hinge" else "free"}
    deepest = []
    for case in both(tmp_path, "end_stop", rig, **options):
        stop = case.case.effects[0].parameters["angle"]
        truth = rolled(case, 1.5)[2]
        q = truth.joint_angle
        if q is None:
            z = rotations.to_matrix(truth.segments[0].quaternion)[:, :, 2]
            q = np.arctan2(z[:, 0], z[:, 2])
        deepest.append(float(np.max(np.sign(stop) * (q - stop))))
        measured = float(np.max(np.sign(stop) * (case.case.world.angle[0] - stop)))
    assert measured > 0.0
    # It comes with up to 7 rad/s; the law's prior has 100 N m/rad, on 0.05 to 0.3 kg m^2: 20 to 45 rad/s.
    assert 0.0 < deepest[0] < 0.3
    assert deepest[1] > 2 * deepest[0], deepest

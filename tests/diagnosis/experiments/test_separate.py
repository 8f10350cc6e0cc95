"""Which motion would tell two effects apart: what is expected, and what recordings of it then show."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.experiments.design import at_size, expected, separate, separation
from imubench.diagnosis.experiments.motion_menu import MENU, Swing, swung
from imubench.diagnosis.experiments.symmetries import same_readings
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof import played
from imubench.proof.case import make_case
from imubench.proof.frames import in_world
from imubench.proof.options import World
from imubench.recording import Body, Encoder
from imubench.run import simulate

MOTIONS = {m.name: m for m in MENU}


def explained(folder, asked, seed, rig="hinge", seconds=12.0, **options):
    """The fit of a generated recording with its effect in the model, and that effect."""
    make_case(folder / "case", rig, effects=[asked], seed=seed, seconds=seconds, **options)
    fit = nominal_fit(read(folder / "case")[0])
    h = Hypothesis(EFFECTS[asked[0]].suited(fit.model.recording), asked[1])
    fit = refit(fit, (*(o for o in fit.model.hypotheses if o.name != h.name), h))
    return with_noise(fit, 1), h


def lost(fit, h, rival):
    """What the fit loses with the rival in the place of `h`, by refitting."""
    rest = tuple(o for o in fit.model.hypotheses if o != h)
    begun = extended(fit, (*rest, rival))
    return solve(begun.model, begun.state, begun.noise, fit.anchor, steps=12).cost - fit.cost


@pytest.mark.slow
def test_nothing_separates_a_moving_centre_from_skin_that_slides_with_it(tmp_path):
    fit, h = explained(tmp_path, ("moving_centre", "joint"), 3)
    skin = EFFECTS["skin_sliding"]
    one, two = separate(fit, [(h, Hypothesis(skin, "imu1")), (h, Hypothesis(skin, "imu2"))])
    assert one is None
    assert two is not None
    assert separation(fit, h, [Hypothesis(skin, "imu1")]) == ""


@pytest.mark.slow
def test_poses_or_tilts_separate_a_bias_from_a_scale(tmp_path):
    fit, h = explained(tmp_path, ("accel_bias", "imu2"), 3)
    (found,) = separate(fit, [(h, Hypothesis(EFFECTS["accel_scale"], "imu2"))])
    assert found.motion.name in ("static poses", "slow tilts")
    assert found.sentence.startswith("20 s of ")
    assert found.sentence.endswith(f": expected log Bayes factor {found.gain:.0f}")


@pytest.mark.long
@pytest.mark.parametrize(("options", "told"), [({"swing": True}, ""), ({}, ", mass and inertia declared")])
def test_a_free_swing_separates_gravity_from_a_scale(tmp_path, options, told):
    fit, h = explained(tmp_path, ("gravity", "world"), 3, rig="pendulum", **options)
    (found,) = separate(fit, [(h, Hypothesis(EFFECTS["accel_scale"], "imu1"))])
    assert found.motion.name == "free swing"
    assert found.sentence.startswith(f"20 s of free swing from 1 rad{told}: ")
    (promised,) = expected(fit, [(h, Hypothesis(EFFECTS["accel_scale"], "imu1"))], found.motion)
    assert found.gain == pytest.approx(promised, rel=0.02)  # 0.1 % here: the effect is small, the motion slow


@pytest.mark.long
@pytest.mark.parametrize("rival", ["dry_friction", "air_drag"])
def test_a_free_swing_from_1_rad_separates_friction(tmp_path, rival):
    """The generator's own swing from 1.02 rad in this seed, and what was expected of one from 1 rad."""
    fit, h = explained(tmp_path, ("viscous_friction", "joint"), 3, seconds=23.0, base="fixed", swing=True)
    other = Hypothesis(EFFECTS[rival], "joint")
    ((start, end),) = fit.model.recording.free_swings
    (found,) = separate(fit, [(h, other)], end - start)
    assert found.motion.name == "free swing"
    # the power of friction grows with the square of the swing: 4 % for 2 %, and as much for the noise's own part
    assert found.gain == pytest.approx(lost(fit, h, other), rel=0.15)


def tilting(options, effects, t, gravity, seed):
    """The menu's slow tilts, by the generator's kinematics."""
    still = np.zeros((len(t), 3))

    def wave(size, rate, phase=0.0):
        x = rate * t + phase
        return size * np.sin(x), size * rate * np.cos(x), -size * rate**2 * np.sin(x)

    first = in_world(still, still, gravity).rotated(1, *wave(1.0, 0.37, 1.0)).rotated(0, *wave(1.2, 0.5))
    bent = wave(0.8, 0.43)
    return World(t, [first, first.rotated(1, *bent)], bent, [], {"motion": "hand", "base": "free"}, 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_slow_tilts_show_as_much_as_expected(tmp_path, monkeypatch, seed):
    monkeypatch.setattr(played, "hinge", tilting)
    bias = {"bias": [0.02, -0.01, 0.02]}
    fit, h = explained(tmp_path, ("accel_bias", "imu2", bias), seed, seconds=20.0)
    scale = Hypothesis(EFFECTS["accel_scale"], "imu2")
    (gain,) = expected(fit, [(h, scale)], MOTIONS["slow tilts"])
    real = lost(fit, h, scale)
    assert real > 100  # nat: far enough from nothing for the comparison to mean something
    assert gain == pytest.approx(real, abs=3 * np.sqrt(2 * real))  # the noise's own part of a log Bayes factor


def test_a_swing_takes_as_long_as_a_pendulum_s():
    body = Body(1.0, np.array([0.0, 0.0, -0.3]), np.full(3, 1e-9))
    time = np.arange(0.0, 10.0, 0.002)
    angle = swung(time, Swing(body, np.eye(3), 9.81, lambda q, w: 0.0))
    falls = time[1:][(angle[:-1] > 0) & (angle[1:] <= 0)]
    exact = 1.0663 * 2 * np.pi * np.sqrt(0.3 / 9.81)  # 1 + x^2/16 + 11 x^4/3072 at x = 1 rad
    assert np.mean(np.diff(falls)) == pytest.approx(exact, rel=2e-3)  # steps of 5 ms
    assert angle.max() == pytest.approx(1.0, abs=0.01)


@pytest.fixture(scope="module")
def late(tmp_path_factory):
    """A hinge whose second clock is late, and that clock's error."""
    return explained(tmp_path_factory.mktemp("late"), ("time_offset", "imu2"), 3)


@pytest.mark.long
def test_no_motion_is_recommended_for_a_relabelling_of_time(late):
    fit, h = late
    assert separation(fit, h, [Hypothesis(h.effect, "imu1")]) == ""
    taps = MOTIONS["taps"]
    promised = expected(fit, [(h, Hypothesis(h.effect, "imu1"))], taps)[0]
    assert promised > 1000  # nat: the linear prediction promises what the splines cannot follow
    assert at_size(fit, h, Hypothesis(h.effect, "imu1"), taps) < EVIDENCE.clear_nat  # and simulating it shows nothing


def test_symmetries_are_those_that_hold_for_the_recording():
    recording = simulate("hinge-hand", seed=1)[0]
    clock = EFFECTS["time_offset"]
    clocks = Hypothesis(clock, "imu1"), Hypothesis(clock, "imu2")
    assert same_readings(*clocks, recording, swings=True)
    time = recording.imus[0].time
    third = replace(recording, encoders=(Encoder("hinge", time, np.zeros(len(time))),))
    assert not same_readings(*clocks, third, swings=True)  # the encoder's clock tells which one is late
    centre, skin = Hypothesis(EFFECTS["moving_centre"], "joint"), Hypothesis(EFFECTS["skin_sliding"], "imu1")
    assert same_readings(centre, skin, recording, swings=True) and same_readings(skin, centre, recording, swings=True)
    assert not same_readings(centre, skin, replace(recording, base="fixed"), swings=True)
    assert not same_readings(centre, Hypothesis(EFFECTS["skin_sliding"], "imu2"), recording, swings=False)
    weight, scale = Hypothesis(EFFECTS["gravity"], "world"), Hypothesis(EFFECTS["accel_scale"], "imu1")
    assert [same_readings(weight, scale, recording, swings) for swings in (False, True)] == [True, False]
    assert not same_readings(weight, Hypothesis(EFFECTS["accel_bias"], "imu1"), recording, swings=False)


@pytest.mark.slow
def test_a_promise_at_finite_size_is_what_a_recording_then_shows(tmp_path, monkeypatch):
    monkeypatch.setattr(played, "hinge", tilting)
    bias = {"bias": [0.02, -0.01, 0.02]}
    fit, h = explained(tmp_path, ("accel_bias", "imu2", bias), 1, seconds=20.0)
    scale = Hypothesis(EFFECTS["accel_scale"], "imu2")
    gain, real = at_size(fit, h, scale, MOTIONS["slow tilts"]), lost(fit, h, scale)
    assert gain == pytest.approx(real, abs=3 * np.sqrt(2 * real))  # the noise's own part of a log Bayes factor

"""The bounds of an effect's visibility: the linearised motion, what must be hidden, and known orders."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.proof.aimed import aimed, make_aimed
from imubench.proof.bounds import bounds, visibility
from imubench.proof.case import build
from imubench.proof.frames import STEP, Track, read_at
from imubench.proof.linearised import blocks, components
from imubench.proof.mounts import sensor_track
from imubench.proof.rotation import apply_back, exp
from imubench.proof.sensors import kept
from imubench.proof.sight import channels, noise_of, sight

SHORT = {"seconds": 12.0, "rest": 0.0}


def wobbles(t, count, rng):
    """Small smooth functions of time with two derivatives, (3, n, count)."""
    rate, phase = rng.uniform(2, 12, count), rng.uniform(0, 6, count)
    angle = rate * t[:, None] + phase
    return 1e-5 * np.array([np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)])


@pytest.mark.parametrize(
    ("rig", "options"), [("hinge", {}), ("hinge", {"base": "fixed"}), ("pendulum", {}), ("free", {})]
)
def test_the_linearised_motion_is_the_change_of_the_frames(rig, options):
    case = build(rig, [], seed=4, noise=0.0, **SHORT, **options)
    world, c = case.world, components(case)
    x, x1, x2 = wobbles(world.t, c, np.random.default_rng(1))
    first = world.segments[0]
    if rig == "hinge":
        if c == 7:
            base = Track(first.p, first.R, first.w + x[:, :3], first.dw + x1[:, :3], first.f + x[:, 3:6])
        else:
            base = first
        angle = tuple(a + b[:, -1] for a, b in zip(world.angle, (x, x1, x2), strict=True))
        changed = [base, base.rotated(1, *angle)]
    else:
        moved = first
        if c == 6:
            moved = Track(first.p, first.R, first.w, first.dw, first.f + apply_back(first.R, x2[:, 3:]))
        changed = [moved.turned(exp(x[:, :3]), x1[:, :3], x2[:, :3])]
    found = blocks(case, dict.fromkeys(channels(case), 1.0))
    for i, (segment, mount) in enumerate(zip(changed, case.mounts, strict=True)):
        after, before = sensor_track(world, segment, mount, "imu1", []), case.tracks[i]
        for k, channel in enumerate(("w", "f")):
            block = found[2 * i + k]
            expected = read_at(block.time, getattr(after, channel) - getattr(before, channel))
            parts = [read_at(block.time, part) for part in (x, x1, x2)]
            change = sum(np.einsum("mkc,mc->mk", S, part) for S, part in zip(block.S, parts, strict=True))
            assert np.abs(change - expected).max() < 1e-3 * np.abs(expected).max() + 1e-12  # second order: 1e-5 of it
    assert STEP == 1e-3


def test_a_bias_is_seen_as_well_as_its_own_samples_allow():
    """A body at rest with its pose measured: bias and nothing else, so its bound is noise over root of the number."""
    case = build("free", [("gyro_bias", "imu1", {"bias": [0.01, 0.0, 0.0]})], seed=1, rest=1.0, seconds=30.0)
    mean, slope = 0.002 / np.sqrt(3000), 0.004 * np.sqrt(12 / 3000) / 30.0  # of the gyroscope, of the measured turn
    assert visibility(case) == pytest.approx(0.01 / np.hypot(mean, slope), rel=0.03)  # ends of the splines


def test_visibility_grows_with_the_effect_and_with_time():
    one, two = (build("hinge", [("gyro_scale", "imu2", {"scale": [k, 0, 0]})], seed=3, **SHORT) for k in (0.01, 0.02))
    assert visibility(two) == pytest.approx(2 * visibility(one), rel=1e-6)
    longer = build("hinge", [("gyro_scale", "imu2", {"scale": [0.01, 0, 0]})], seed=3, seconds=24.0, rest=0.0)
    assert visibility(longer) > 1.2 * visibility(one)


def test_what_a_motion_explains_cannot_be_seen():
    case = build("hinge", [], seed=3, **SHORT)
    seen, R = sight(case), case.mounts[0].rotation
    twist = {"slide": [0.0, 0.0, 0.0], "twist": 0.02 * R[1]}  # about the hinge axis: another gain of the angle
    turned = seen.readings(build("hinge", [("skin_sliding", "imu1", twist)], seed=3, **SHORT).effects)
    across = {"slide": [0.0, 0.0, 0.0], "twist": 0.02 * R[0]}
    tilted = seen.readings(build("hinge", [("skin_sliding", "imu1", across)], seed=3, **SHORT).effects)
    plain = seen.readings([])
    hidden, open_ = (float(np.sqrt(seen.information((x - plain)[:, None])[0, 0])) for x in (turned, tilted))
    assert hidden < 0.3 * open_  # its lever still shows
    heavy = build("hinge", [("gravity", "world", {"g": 9.9})], seed=3, **SHORT)
    assert visibility(heavy) < 0.5  # the hand may have accelerated


def test_the_equivalent_effects_of_the_table_look_the_same():
    slide = np.array([0.01, -0.02, 0.015])
    seen = sight(build("hinge", [], seed=9, **SHORT))
    plain = seen.readings([])
    changes = [
        seen.readings(build("hinge", [effect], seed=9, **SHORT).effects) - plain
        for effect in (
            ("moving_centre", "joint", {"slide": slide}),
            ("skin_sliding", "imu1", {"slide": -slide}),
            ("skin_sliding", "imu1", {"slide": slide}),
        )
    ]
    alone, same, opposite = (
        float(np.sqrt(seen.information(x[:, None])[0, 0]))
        for x in (changes[0], changes[0] - changes[1], changes[0] - changes[2])
    )
    assert same < 0.02 * alone and opposite > 1.9 * alone  # the lever of segment 1 differs by the slide, second order


@pytest.mark.long
def test_bounds_agree_with_visibility_and_with_known_orders():
    case = build("hinge", [("time_offset", "imu2", {"offset": 1e-3})], seed=2, seconds=20.0)
    bound = bounds(case)["offset"]
    assert 1e-3 / bound == pytest.approx(visibility(case), rel=0.02)  # one parameter: the same number
    assert 1e-6 < bound < 2e-5  # microseconds
    soft = bounds(
        build("hinge", [("soft_mount", "imu2", {"frequency": 10.0, "damping_ratio": 0.1})], seed=2, seconds=20.0)
    )
    assert soft["frequency"] < 0.2 and soft["damping_ratio"] < 0.05
    swing = build("pendulum", [("air_drag", "joint")], seed=2, swing=True, seconds=5.0)
    assert bounds(swing) is None and visibility(swing) is None


@pytest.mark.parametrize("name", ["gyro_scale", "soft_mount", "saturation", "mount_pose", "skin_sliding", "low_pass"])
def test_an_effect_is_drawn_to_the_visibility_that_is_wanted(name):
    case = build("hinge", [(name, "imu2")], seed=6, **SHORT)
    seen = sight(case)
    for wanted in (3.0, 30.0):
        _, reached = aimed(case.effects[0], case, seen, wanted)
        assert reached == pytest.approx(wanted, rel=0.06)


@pytest.mark.parametrize("encoder", [False, True])
def test_a_mount_turned_about_a_free_hinge_is_not_seen_without_an_encoder(encoder):
    """The hinge's angle takes the turn up, however far the mount is off."""
    far = ("mount_pose", "imu2", {"rotation": [0.19, 0.28, -0.09], "translation": [-0.1, 0.07, -0.05]})
    case = build("hinge", [far], 7, seconds=10.0, encoder=encoder)
    turned = np.linalg.norm(bounds(case)["rotation"])
    assert turned < 0.02 if encoder else turned > 1.0


@pytest.mark.long
@pytest.mark.filterwarnings("error")
def test_a_mount_too_hard_to_have_a_motion_is_not_drawn():
    case = build("hinge", [("hardening_mount", "imu2")], seed=6, **SHORT)
    seen = sight(case)
    effect, reached = aimed(case.effects[0], case, seen, 1e6)
    assert np.isfinite(reached)
    assert np.isfinite(seen.readings([effect])).all()


def test_an_aimed_case_is_written_with_what_it_reached(tmp_path):
    effects = [("gyro_bias", "imu1"), ("gyro_noise", "imu2")]
    truth = make_aimed(tmp_path / "a", "hinge", effects, 3, [10.0, 10.0], **SHORT)
    assert truth["visibility"][0] == pytest.approx(10, rel=0.06) and truth["visibility"][1] is None
    assert (tmp_path / "a" / "recording.toml").exists()


@pytest.mark.parametrize("corner", [None, 0.5])
def test_coloured_noise_hides_what_is_slow(corner):
    """Against generalised least squares with every channel's covariance written out, k^|i - j| for its colour."""
    options = {"seconds": 2.0, "rate": 50.0, "colour": 0.2, "corner": corner}
    case = build("hinge", [("accel_bias", "imu1")], 3, **options)
    seen, plain = sight(case), sight(replace(case, options=replace(case.options, colour=0.0)))
    change = (seen.readings(case.effects) - seen.readings([]))[:, None]
    covariance, first = np.eye(len(change)), 0
    for block in seen.parts:
        at, _, channel = block.name.partition(".")
        m = len(block.time)
        lag = np.abs(np.subtract.outer(np.arange(m), np.arange(m)))
        own = slice(first, first + 3 * m)
        after_a_sample = kept(m, channel, at, 50.0, case.seed) if corner is None else np.exp(-2 * np.pi * corner / 50.0)
        covariance[own, own] += 0.2 * np.kron(after_a_sample**lag, np.eye(3))
        first += 3 * m
    found, expected = [], []
    for sees, noise in ((seen, covariance), (plain, np.eye(len(change)))):
        whiten = np.linalg.inv(np.linalg.cholesky(noise))
        A, d = whiten @ plain.A.toarray(), whiten @ change
        left = d - A @ np.linalg.lstsq(A, d, rcond=1e-9)[0]
        expected.append(float((left**2).sum()))
        found.append(float(sees.information(change, slice(0, 0))[0, 0]))
    np.testing.assert_allclose(found, expected, rtol=0.03)  # sparse equations hold a motion that nothing sees at zero
    assert found[0] / found[1] == pytest.approx(expected[0] / expected[1], rel=5e-3)
    assert visibility(case, seen) < 0.7 * visibility(case, plain)


def test_lost_samples_beside_an_effect_leave_its_bound_defined():
    lost = ("dropouts", "imu1", {"fraction": 0.2, "mode": "missing"})
    drift = ("accel_drift", "imu1", {"rate": np.array([1e-3, 2e-3, -1e-3])})
    case = build("pendulum", [lost, drift], 3, seconds=6.0)
    alone = build("pendulum", [drift], 3, seconds=6.0)
    assert bounds(case, 1)["rate"] == pytest.approx(bounds(alone)["rate"], rel=1e-6)  # the same rows and derivatives


def test_an_effect_is_as_visible_as_the_noise_beside_it_allows():
    drift = ("accel_drift", "imu1", {"rate": np.array([1e-3, 2e-3, -1e-3])})
    quiet = build("pendulum", [drift], 3, seconds=6.0)
    std = {c: noise_of(quiet, f"imu1.{c}") for c in ("gyro", "accel")}
    louder = [(f"{c}_noise", "imu1", {"std": 3 * std[c]}) for c in std]
    loud = build("pendulum", [drift, *louder], 3, seconds=6.0)
    assert bounds(loud)["rate"] == pytest.approx(3 * bounds(quiet)["rate"], rel=0.02)  # but for the declared mounts
    coarse = ("quantisation", "imu1", {"step": float(np.sqrt(12 * 8) * std["accel"]), "channels": ["accel"]})
    rounded = build("pendulum", [drift, coarse], 3, seconds=6.0)
    assert noise_of(rounded, "imu1.accel") == pytest.approx(3 * std["accel"])
    assert noise_of(rounded, "imu1.gyro") == std["gyro"]
    assert np.all(bounds(rounded)["rate"] > 1.5 * bounds(quiet)["rate"])

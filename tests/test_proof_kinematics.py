"""The generator's frames against finite differences of the places and attitudes that they claim."""

import numpy as np
import pytest

from imubench.proof.case import build
from imubench.proof.frames import LEAD, STEP, read_at
from imubench.proof.rotation import (
    about,
    apply,
    euler_xyz,
    exp,
    from_quaternion,
    log,
    random_rotation,
    skew,
    to_quaternion,
)  # fmt: skip

QUIET = {"noise": 0.0, "seconds": 10.0, "geometry_error": False}
JOINT = [("joint_play", "joint"), ("axis_coupling", "joint"), ("moving_centre", "joint")]
MOUNTS = [("soft_mount", "imu1"), ("rocking_mount", "imu2"), ("skin_sliding", "imu2"), ("mount_shift", "imu1")]
CASES = {
    "hinge": ("hinge", [], {}),
    "hinge with a bad joint": ("hinge", JOINT, {}),
    "hinge with bad mounts": ("hinge", MOUNTS, {}),
    "hinge on hard springs": ("hinge", [("hardening_mount", "imu1"), ("creep", "imu2")], {}),
    "fixed hinge": ("hinge", [], {"base": "fixed"}),
    "swinging hinge": ("hinge", [("viscous_friction", "joint")], {"base": "fixed", "swing": True}),
    "pendulum": ("pendulum", [("skin_sliding", "imu1"), ("moving_pivot", "joint")], {}),
    "swinging pendulum": ("pendulum", [("air_drag", "joint"), ("rocking_mount", "imu1")], {"swing": True}),
    "free body": ("free", [("soft_mount", "imu1")], {"gravity": 9.7}),
}  # fmt: skip


def slope(x):
    """Fourth-order central difference along the first axis, for points 2 to n - 3."""
    return (x[:-4] - 8 * x[1:-3] + 8 * x[3:-1] - x[4:]) / (12 * STEP)


def curvature(x):
    return (-x[:-4] + 16 * x[1:-3] - 30 * x[2:-2] + 16 * x[3:-1] - x[4:]) / (12 * STEP**2)


@pytest.mark.parametrize("name", list(CASES))
def test_rates_and_specific_forces_are_derivatives_of_places(name):
    rig, effects, options = CASES[name]
    case = build(rig, effects, seed=11, strength="medium", **{**QUIET, **options})
    for track in (*case.world.segments, *case.tracks):
        part = slice(2, -2)
        W = np.swapaxes(track.R[part], 1, 2) @ slope(track.R)
        w = np.stack([W[:, 2, 1], W[:, 0, 2], W[:, 1, 0]], -1)
        f = np.einsum("nji,nj->ni", track.R[part], curvature(track.p) + np.array([0, 0, case.options.gravity]))
        # a hand lets go, or a motion starts to shift, within a step: there differences are blurred
        errors = [np.abs(a - b[part]).max(axis=1) for a, b in ((w, track.w), (slope(track.w), track.dw), (f, track.f))]
        scale = [1.0, 30.0, 10.0]  # rad/s, rad/s^2, m/s^2
        for error, size in zip(errors, scale, strict=True):
            smooth = np.quantile(error, 0.995) / size
            assert smooth < 2e-5  # h^4 at 20 Hz: (2 pi 20 h)^4 / 30 = 1e-5


def test_an_imu_at_rest_reads_gravity_upwards():
    for rig in ("hinge", "pendulum", "free"):
        case = build(rig, [], seed=4, rest=1.0, **QUIET)
        for track in case.tracks:
            assert np.allclose(apply(track.R, track.f), [0, 0, 9.81], atol=1e-12)  # rounding
            assert not track.w.any()


def test_the_hinge_turns_about_y_and_its_segments_share_their_origin():
    case = build("hinge", [], seed=8, **QUIET)
    first, second = case.world.segments
    relative = np.swapaxes(first.R, 1, 2) @ second.R
    q = case.world.angle[0]
    assert np.allclose(relative[:, 1, 1], 1, atol=1e-12)
    assert np.allclose(np.arctan2(relative[:, 0, 2], relative[:, 0, 0]), q, atol=1e-12)
    assert np.array_equal(first.p, second.p) and np.ptp(q) > 0.5
    assert case.mounts[0].position[0] < 0 < case.mounts[1].position[0]


def test_the_pendulums_swing_is_the_angle_of_its_limb_about_world_y():
    case = build("pendulum", [], seed=8, **QUIET)
    R, (q, q1, q2) = case.world.segments[0].R, case.world.angle
    assert np.allclose(np.arctan2(R[:, 0, 2], R[:, 2, 2]), q, atol=1e-12)
    assert np.abs(slope(q) - q1[2:-2]).max() < 1e-5 and np.abs(slope(q1) - q2[2:-2]).max() < 3e-4  # h^4, as above


def test_the_motion_is_band_limited_and_rests_now_and_then():
    rates = []
    for seed in range(6):
        case = build("hinge", [], seed=seed, band=10.0, noise=0.0, seconds=60.0)
        w = case.tracks[1].w[2000:-600]
        still = np.linalg.norm(w, axis=1) < 1e-9
        rates.append(still.mean())
        power = np.abs(np.fft.rfft(w * np.hanning(len(w))[:, None], axis=0)) ** 2
        frequency = np.fft.rfftfreq(len(w), STEP)
        assert power[frequency > 25].sum() < 1e-3 * power.sum()  # angles of 10 Hz compose to a little more
        assert power[frequency > 4].sum() > 1e-4 * power.sum()
    assert 0.02 < np.mean(rates) < 0.5


def test_read_at_is_exact_between_grid_points():
    t = STEP * np.arange(-2000, 1500)
    wave = np.sin(2 * np.pi * 20 * t)[:, None] * [1.0, -2.0]
    times = np.random.default_rng(1).uniform(-1.9, 1.4, 500)
    assert LEAD == 2.0
    assert np.abs(read_at(times, wave) - np.sin(2 * np.pi * 20 * times)[:, None] * [1, -2]).max() < 1e-6


def test_rotations_agree_with_each_other():
    rng = np.random.default_rng(2)
    R = np.array([random_rotation(rng) for _ in range(50)])
    assert np.allclose(R @ np.swapaxes(R, 1, 2), np.eye(3)) and np.allclose(np.linalg.det(R), 1)
    assert np.allclose(from_quaternion(to_quaternion(R)), R) and np.allclose(exp(log(R)), R)
    v = rng.standard_normal((50, 3))
    assert np.allclose(apply(skew(v), R[:, 0]), np.cross(v, R[:, 0]))
    assert np.allclose(exp(np.zeros(3)), np.eye(3)) and np.allclose(log(np.eye(3)), 0)
    a, b, c = euler_xyz(R[0])
    assert np.allclose(about(0, a) @ about(1, b) @ about(2, c), R[0])
    assert np.allclose(about(1, 0.3), exp([0, 0.3, 0]))
    assert np.allclose(about(1, np.pi / 2) @ [1, 0, 0], [0, 0, -1])  # +y takes x to -z

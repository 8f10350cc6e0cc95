"""The generator's mounts against what springs, sags and levers must do, and the sign of every parameter."""

import numpy as np
import pytest
from scipy.optimize import curve_fit

from imubench.proof.case import build
from imubench.proof.frames import STEP, Track
from imubench.proof.rotation import apply_back, exp, from_quaternion, log
from imubench.proof.springs import rocking, soft
from imubench.proof.unknown import hardening

QUIET = {"noise": 0.0, "seconds": 8.0, "geometry_error": False}
T = STEP * np.arange(3000)


def standing(f=None, dw=None):
    """A frame whose specific force or angular acceleration is given, and that does not turn (so soon)."""
    zero = np.zeros((len(T), 3))
    R = np.broadcast_to(np.eye(3), (len(T), 3, 3))
    return Track(zero, R, zero, zero if dw is None else dw, zero if f is None else f)


def ringing(t, size, frequency, damping, phase, offset):
    w = 2 * np.pi * frequency
    return size * np.exp(-damping * w * t) * np.cos(w * np.sqrt(1 - damping**2) * t + phase) + offset


def test_a_soft_mount_sags_rings_and_settles_as_declared():
    frequency, damping = np.array([12.0, 9.0, 7.0]), 0.06
    f = np.tile([0.0, 0.0, 9.81], (len(T), 1))
    f[1000:] += [1.0, -2.0, 0.5]
    track = soft(standing(f), {"frequency": frequency, "damping_ratio": damping})
    assert np.allclose(track.p[:999], [0, 0, -9.81 / (2 * np.pi * 7.0) ** 2], rtol=1e-9)  # nothing moves yet
    assert np.allclose(track.p[-1], -np.array([1, -2, 10.31]) / (2 * np.pi * frequency) ** 2, atol=3e-5)  # still rings
    for axis in range(3):
        x = track.p[1001:, axis]
        guess = (x.max() - x.min(), frequency[axis] * 1.02, 0.1, 3.0, x[-1])
        _, found, loss, _, _ = curve_fit(ringing, T[1001:] - T[1001], x, guess)[0]
        assert abs(found / frequency[axis] - 1) < 1e-4 and abs(abs(loss) / damping - 1) < 1e-3  # Runge-Kutta at 1 ms
    # what the mass feels is what the springs and dampers give
    x1 = np.gradient(track.p, STEP, axis=0)
    w = 2 * np.pi * frequency
    assert np.allclose((-(w**2) * track.p - 2 * damping * w * x1)[1100:], track.f[1100:], atol=0.01)  # of np.gradient


def test_a_soft_mount_on_a_turntable_flies_outwards():
    rate, n = 5.0, len(T)
    w = np.tile([0.0, 0.0, rate], (n, 1))
    place = np.array([0.2, 0.0, 0.0])
    centre = Track(np.zeros((n, 3)), exp(np.outer(T, w[0])), w, 0 * w, np.zeros((n, 3)))
    track = soft(centre.placed(place), {"frequency": 10.0, "damping_ratio": 0.1})
    k = (2 * np.pi * 10) ** 2
    stretched = 0.2 * k / (k - rate**2)  # k (r - 0.2) = rate^2 r
    assert np.allclose(np.linalg.norm(track.p[-1]), stretched, rtol=1e-9)  # it starts there already
    assert np.allclose(track.f[-1], [-(rate**2) * stretched, 0, 0], atol=1e-9)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_rocking_mount_lags_behind_and_rings(axis):
    damping, frequency, push = 0.08, np.array([10.0, 14.0, 11.0]), 4.0 * np.eye(3)[axis]
    dw = np.zeros((len(T), 3))
    dw[1000:] = push
    track = rocking(standing(dw=dw), {"frequency": frequency, "damping_ratio": [damping] * 3})
    turn = log(track.R)
    assert np.allclose(turn[:999], 0, atol=1e-15)  # nothing moves yet
    assert np.allclose(turn[-1], -push / (2 * np.pi * frequency) ** 2, atol=2e-5)  # it lags; it still rings a little
    x = turn[1001:, axis]
    guess = (x.max() - x.min(), frequency[axis] * 1.01, 0.1, 3.0, x[-1])
    _, found, loss, _, _ = curve_fit(ringing, T[1001:] - T[1001], x, guess)[0]
    assert abs(found / frequency[axis] - 1) < 1e-4 and abs(abs(loss) / damping - 1) < 1e-3  # Runge-Kutta at 1 ms


def test_the_off_centre_mass_of_a_rocking_mount_hangs_and_its_lever_swings():
    com, gyration, lever = np.array([0.004, 0.0, 0.0]), 0.015, np.array([0.0, 0.0, 0.02])
    f = np.tile([0.0, 0.0, 9.81], (len(T), 1))
    p = {"frequency": 12.0, "damping_ratio": 0.1, "com": com, "gyration": gyration, "lever": lever}
    track = rocking(standing(f), p)
    tilt = log(track.R[-1])
    # weight on the +x side pushes it down, about +y: gyration^2 (2 pi 12)^2 tilt = com g cos(tilt)
    assert np.allclose(tilt[[0, 2]], 0, atol=1e-12) and tilt[1] > 0.03
    assert np.isclose(gyration**2 * (2 * np.pi * 12) ** 2 * tilt[1], 0.004 * 9.81 * np.cos(tilt[1]), rtol=1e-6)
    assert np.allclose(track.p[-1], exp(tilt) @ lever - lever, atol=1e-12)
    assert np.allclose(track.f[-1], exp(-tilt) @ [0, 0, 9.81], atol=1e-9)


def test_a_hardening_mount_is_stiffer_the_further_it_goes():
    f = np.tile([0.0, 0.0, 9.81], (len(T), 1))
    p = {"frequency": 8.0, "damping_ratio": 0.1, "span": 0.003}
    z = hardening(standing(f), p).p[-1, 2]
    k = (2 * np.pi * 8) ** 2
    assert abs(k * z * (1 + (z / 0.003) ** 2) + 9.81) < 1e-6 and z > -9.81 / k


def test_mount_pose_turns_on_the_right_and_shifts_in_the_segment():
    p = {"rotation": [0.1, -0.2, 0.3], "translation": [0.01, 0.02, -0.03]}
    plain, with_it = (build("hinge", e, seed=3, **QUIET) for e in ([], [("mount_pose", "imu2", p)]))
    segment, mount = with_it.world.segments[1], with_it.mounts[1]
    relative = np.swapaxes(segment.R, 1, 2) @ with_it.tracks[1].R
    assert np.allclose(relative, mount.declared_rotation @ exp(p["rotation"]))
    there = apply_back(segment.R, with_it.tracks[1].p - segment.p)
    assert np.allclose(there, mount.declared_position + p["translation"])
    assert np.array_equal(plain.tracks[0].f, with_it.tracks[0].f)


def test_a_shift_takes_place_within_0_3_s_of_its_time():
    p = {"time": 4.0, "rotation": [0.1, 0.0, 0.05], "translation": [0.01, 0.0, 0.0]}
    plain, with_it = (build("free", e, seed=3, **QUIET) for e in ([], [("mount_shift", "imu1", p)]))
    t, relative = plain.world.t, np.swapaxes(plain.tracks[0].R, 1, 2) @ with_it.tracks[0].R
    turned = log(relative)
    assert np.abs(turned[t <= 4.0]).max() < 1e-12 and np.allclose(turned[t > 4.3], p["rotation"], atol=1e-12)
    moved = apply_back(plain.world.segments[0].R, with_it.tracks[0].p - plain.tracks[0].p)
    assert np.allclose(moved[t > 4.3], p["translation"]) and np.abs(moved[t <= 4.0]).max() < 1e-12


@pytest.mark.parametrize(("rig", "at"), [("hinge", "imu1"), ("hinge", "imu2"), ("pendulum", "imu1")])
def test_skin_slides_and_twists_with_the_angle(rig, at):
    p = {"slide": [0.01, -0.02, 0.03], "twist": [0.05, 0.02, -0.03]}
    plain, with_it = (build(rig, e, seed=3, **QUIET) for e in ([], [("skin_sliding", at, p)]))
    i, q = int(at[-1]) - 1, plain.world.angle[0]
    assert np.allclose(log(np.swapaxes(plain.tracks[i].R, 1, 2) @ with_it.tracks[i].R), np.outer(q, p["twist"]))
    moved = apply_back(plain.world.segments[i].R, with_it.tracks[i].p - plain.tracks[i].p)
    assert np.allclose(moved, np.outer(q, p["slide"]), atol=1e-12)


def test_geometry_errors_have_the_declared_size():
    off, turn = [], []
    for seed in range(40):
        mounts = build("hinge", [], seed=seed, **{**QUIET, "geometry_error": True, "seconds": 1.0}).mounts
        off += [m.position - m.declared_position for m in mounts]
        turn += [log(m.declared_rotation.T @ m.rotation) for m in mounts]
    assert abs(np.std(off) / 0.004 - 1) < 0.15 and abs(np.std(turn) / 0.02 - 1) < 0.15  # 240 numbers: 5 %, thrice
    assert np.allclose(from_quaternion([1, 0, 0, 0]), np.eye(3))

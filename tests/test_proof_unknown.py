"""Physics outside the table, each against its equation, seen from outside."""

import numpy as np
import pytest

from imubench.proof.case import build
from imubench.proof.frames import read_at
from imubench.proof.rotation import log

QUIET = {"noise": 0.0, "seconds": 20.0, "geometry_error": False}
KEYS = {"gyro": "w", "accel": "f"}


def read(name, p):
    """Stamps, and readings and truth of imu2's gyro and accel under one such effect."""
    case = build("hinge", [(name, "imu2", p)], seed=3, **QUIET)
    samples, track = case.imus[1], case.tracks[1]
    assert not case.effects[0].inside
    return samples, {channel: read_at(samples.time, getattr(track, key)) for channel, key in KEYS.items()}


def test_a_bias_jumps():
    samples, true = read("bias_jump", {"channel": "accel", "jump": [0.1, -0.2, 0.3], "time": 9.0})
    off = samples.accel - true["accel"]
    assert not off[samples.time < 9].any() and np.allclose(off[samples.time >= 9], [0.1, -0.2, 0.3])
    assert np.array_equal(samples.gyro, true["gyro"])


@pytest.mark.long
def test_a_thermal_walk_grows_with_the_root_of_time():
    walks = []
    for seed in range(30):
        case = build(
            "free", [("thermal_walk", "imu1", {"channel": "gyro", "density": 0.01})], seed=seed, rest=1.0, **QUIET
        )
        walks.append(case.imus[0].gyro)
    quarter, whole = (np.std([walk[k] for walk in walks]) for k in (len(walks[0]) // 4, -10))
    assert abs(whole / (0.01 * np.sqrt(20)) - 1) < 0.25 and abs(quarter / whole - 0.5) < 0.15  # 90 numbers each: 8 %


def test_cubes_dead_bands_and_hysteresis():
    samples, true = read("cubic", {"channel": "accel", "factor": 1e-4})
    assert np.allclose(samples.accel, true["accel"] + 1e-4 * true["accel"] ** 3, atol=1e-6)  # read between grid points
    samples, true = read("dead_band", {"channel": "gyro", "width": 0.2})
    inside = np.abs(true["gyro"]) < 0.19
    assert np.abs(samples.gyro[inside]).max() < 1e-3 and np.allclose(
        np.abs(samples.gyro - true["gyro"])[np.abs(true["gyro"]) > 0.25], 0.2
    )
    samples, true = read("hysteresis", {"channel": "gyro", "share": 0.1, "width": 0.3})
    off = samples.gyro - true["gyro"]
    assert np.abs(off).max() <= 0.1 * 0.3 + 1e-4
    rising = np.gradient(true["gyro"][:, 1]) > 0.05
    falling = np.gradient(true["gyro"][:, 1]) < -0.05
    assert off[rising, 1].mean() < -0.02 and off[falling, 1].mean() > 0.02  # the loop lags


def test_cross_talk_comes_late():
    samples, true = read("cross_talk", {"from": 0, "to": 2, "share": 0.1, "delay": 0.05})
    case = build("hinge", [], seed=3, **QUIET)
    late = read_at(samples.time - 0.05, case.tracks[1].w)[:, 0]
    assert np.allclose(samples.gyro[:, 2] - true["gyro"][:, 2], 0.1 * late, atol=1e-9)
    assert np.array_equal(samples.gyro[:, :2], true["gyro"][:, :2])


def test_rectification_follows_the_shaking():
    samples, true = read("rectification", {"factor": [0.01, 0.0, -0.02]})
    off = samples.accel - true["accel"]
    assert np.allclose(off[:, 2], -2 * off[:, 0]) and (off[:, 0] >= -1e-9).all() and off[:, 0].std() > 0.005
    assert not off[:, 1].any()


def test_a_mount_creeps_to_its_end():
    p = {"rotation": [0.1, 0.0, -0.05], "time_constant": 4.0}
    plain, with_it = (build("hinge", e, seed=3, **QUIET) for e in ([], [("creep", "imu2", p)]))
    turned, t = log(np.swapaxes(plain.tracks[1].R, 1, 2) @ with_it.tracks[1].R), plain.world.t
    assert np.allclose(turned[t > 0], np.outer(1 - np.exp(-t[t > 0] / 4.0), p["rotation"]), atol=1e-12)


def test_cogs_and_wind_push_a_swing():
    swing = {**QUIET, "base": "fixed", "swing": True}
    body = build("hinge", [], seed=3, **swing)
    inertia = None
    for name, p in (("cogging", {"torque": 0.2, "cogs": 6.0}), ("wind", {"std": 0.1, "band": 1.0})):
        case = build("hinge", [(name, "joint", p)], seed=3, **swing)
        (start, end), t = case.world.swings[0], case.world.t
        part = (t > start) & (t < end)
        q, _, q2 = (x[part] for x in case.world.angle)
        qf, _, q2f = (x[part] for x in body.world.angle)
        pull = np.polynomial.Polynomial.fit(np.sin(qf - body.world.hangs), q2f, 1)  # gravity's, from the plain swing
        extra = q2 - pull(np.sin(q - case.world.hangs))
        declared = case.world.declared["body"]
        inertia = declared["inertia"][1] + declared["mass"] * (declared["com"][0] ** 2 + declared["com"][2] ** 2)
        if name == "cogging":
            assert np.allclose(extra * inertia, -0.2 * np.sin(6 * q), atol=1e-6)
        else:
            assert abs((extra * inertia).std() / 0.1 - 1) < 0.4  # some 20 periods
            assert np.abs(np.diff(extra)).max() < 0.05 * np.abs(extra).max()

"""The generator's joints and free swings against energy, period, and the law of each torque."""

import numpy as np
import pytest
from scipy.special import ellipk

from imubench.proof.body import limb
from imubench.proof.case import build
from imubench.proof.instruments import read_encoder
from imubench.proof.options import stream
from imubench.proof.relative import NEARER
from imubench.proof.rotation import about, apply, apply_back, log

SWING = {"noise": 0.0, "seconds": 20.0, "geometry_error": False, "swing": True}
HINGE, BALL = {**SWING, "base": "fixed"}, SWING


def limb_of(rig, seed):
    return limb(stream(seed, "body"), axis=0 if rig == "hinge" else 2)


def swinging(rig, effects, seed, **options):
    """The case, the part of the grid in its window, and the true limb."""
    case = build(rig, effects, seed=seed, **{**(HINGE if rig == "hinge" else BALL), **options})
    (start, end), t = case.world.swings[0], case.world.t
    return case, (t >= start) & (t <= end), limb_of(rig, seed)


def energy(case, part, body, gravity=9.81, scale=1.0):
    track = case.world.segments[-1]
    com = apply(track.R, np.broadcast_to(body.com, track.w.shape))[part]
    turning = 0.5 * np.einsum("ni,ij,nj->n", track.w[part], body.about_pivot / scale, track.w[part])
    return turning + body.mass * gravity * com[:, 2]


@pytest.mark.parametrize("rig", ["hinge", "pendulum"])
def test_a_free_swing_keeps_its_energy(rig):
    for seed in range(3):
        case, part, body = swinging(rig, [], seed)
        E = energy(case, part, body)
        assert np.ptp(E) < 1e-6 * body.mass * 9.81 * np.linalg.norm(body.com)  # Runge-Kutta at 1 ms over 20 s


@pytest.mark.parametrize("rig", ["hinge", "pendulum"])
@pytest.mark.parametrize(
    ("name", "key", "power"),
    [("viscous_friction", "c", 2), ("dry_friction", "t", 1), ("air_drag", "d", 3)],
)
def test_a_resisting_torque_takes_the_energy_that_its_law_says(rig, name, key, power):
    case, part, body = swinging(rig, [(name, "joint")], 5)
    E = energy(case, part, body)
    speed = np.linalg.norm(case.world.segments[-1].w - case.world.segments[0].w * (rig == "hinge"), axis=1)[part]
    taken = case.effects[0].parameters[key] * speed**power
    fast = speed[1:-1] > 0.05  # dry friction fades below 0.01 rad/s
    lost = -(E[2:] - E[:-2])[fast] / 2e-3
    assert fast.mean() > 0.2 and taken.max() > 0.01
    assert np.abs(lost - taken[1:-1][fast]).max() < 2e-3 * taken.max()  # central differences at reversals


def period(case, part):
    q, t = case.world.angle[0][part] - case.world.hangs, case.world.t[part]
    up = np.flatnonzero((q[:-1] < 0) & (q[1:] >= 0))
    times = t[up] - q[up] * (t[up + 1] - t[up]) / (q[up + 1] - q[up])
    return (times[-1] - times[0]) / (len(times) - 1)


@pytest.mark.parametrize("scale", [None, 0.8, 1.3])
@pytest.mark.parametrize("g", [None, 9.5])
def test_the_hinges_period_is_the_pendulums(scale, g):
    effects = [("inertia", "body", {"scale": scale})] * (scale is not None) + [("gravity", "world", {"g": g})] * (
        g is not None
    )
    case, part, body = swinging("hinge", effects, 2)
    R = case.world.segments[0].R[0]
    down = R.T @ [0, 0, -(g or 9.81)]
    com = np.delete(body.com, 1)
    moment = body.mass * np.hypot(*com) * np.hypot(down[0], down[2]) * (scale or 1.0)
    top = np.abs(case.world.angle[0][part] - case.world.hangs).max()
    expected = 4 * np.sqrt(body.about_y / moment) * ellipk(np.sin(top / 2) ** 2)
    assert abs(period(case, part) / expected - 1) < 1e-5  # zero crossings between grid points


def test_a_joint_spring_pulls_towards_its_angle():
    p = {"k": 0.8, "q0": 0.4}
    case, part, body = swinging("hinge", [("joint_spring", "joint", p)], 2)
    q, _, q2 = (x[part] for x in case.world.angle)
    free, free_part, _ = swinging("hinge", [], 2)
    qf, _, q2f = (x[free_part] for x in free.world.angle)
    pull = np.polynomial.Polynomial.fit(np.sin(qf - free.world.hangs), q2f, 1)
    extra = (q2 - pull(np.sin(q - free.world.hangs))) * body.about_y
    assert np.allclose(extra, -0.8 * (q - 0.4), atol=1e-6)  # gravity's own torque is a sine of the angle from hanging


@pytest.mark.parametrize("rig", ["hinge", "pendulum"])
def test_a_spring_keeps_the_energy_too(rig):
    p = {"k": 0.5, "q0": 0.2}
    case, part, body = swinging(rig, [("joint_spring", "joint", p)], 3)
    E = energy(case, part, body) + 0.25 * (case.world.angle[0][part] - 0.2) ** 2
    assert np.ptp(E) < 1e-6 * body.mass * 9.81


@pytest.mark.parametrize("rig", ["hinge", "pendulum"])
def test_a_stop_holds_on_its_side_only(rig):
    free, part, _ = swinging(rig, [], 4)
    q = free.world.angle[0][part]
    for side in (-1, 1):
        angle = free.world.hangs + side * 0.5 * np.abs(q - free.world.hangs).max()
        case, inside, _ = swinging(rig, [("end_stop", "joint", {"angle": angle})], 4)
        reached = side * (case.world.angle[0][inside] - angle)
        assert 0.001 < reached.max() < 0.08  # it hits, and is stiff: 25 Hz under a few rad/s
        assert reached.min() < -0.5


@pytest.mark.parametrize("rig", ["hinge", pytest.param("pendulum", marks=pytest.mark.slow)])
def test_a_drawn_stop_is_touched_and_one_that_is_touched_stays_where_it_was_drawn(rig):
    """A stop at 1.2 rad that a swing of less never reached changed no sample of two unseen trials."""
    for seed in (4, 5):
        for far in (0.3, 1.7):
            case, inside, _ = swinging(rig, [("end_stop", "joint", {"from_rest": far})], seed)
            (stop,), hangs = case.effects, case.world.hangs
            off = stop.parameters["angle"] - hangs
            beyond = (case.world.angle[0][inside] - hangs) * np.sign(off) - abs(off)
            assert beyond.max() > 0
            steps = np.log(abs(off) / far) / np.log(NEARER)
            assert steps == pytest.approx(round(steps), abs=1e-9) and (far > 0.3 or steps == pytest.approx(0, abs=1e-9))


def test_the_declared_body_and_windows_are_there():
    case, part, body = swinging("pendulum", [("inertia", "body", {"scale": 1.2})], 4)
    declared = case.world.declared["body"]
    assert np.array_equal(declared["com"], body.com) and declared["mass"] == body.mass
    assert np.ptp(energy(case, part, body, scale=1.2)) < 1e-5 * body.mass


def test_a_moving_pivot_shakes_the_pendulum():
    p = {"std": 0.8, "band": [1.0, 3.0]}
    case = build("pendulum", [("moving_pivot", "joint", p)], seed=6, noise=0.0, seconds=30.0)
    track = case.world.segments[0]
    shaken = apply(track.R, track.f) - [0, 0, 9.81]
    assert np.allclose(shaken.std(axis=0), 0.8, rtol=0.15)  # 60 periods
    power = np.abs(np.fft.rfft(shaken * np.hanning(len(shaken))[:, None], axis=0)) ** 2
    frequency = np.fft.rfftfreq(len(shaken), 1e-3)
    band = (frequency > 0.85) & (frequency < 3.15)
    assert power[band].sum() > 0.999 * power.sum()


def test_play_turns_across_the_axis_within_its_range():
    for kind in ("free", "springy"):
        p = {"range": 0.03, "direction": 0.7, "kind": kind}
        case = build("hinge", [("joint_play", "joint", p)], seed=1, noise=0.0, seconds=20.0)
        first, second = case.world.segments
        left = np.swapaxes(first.R @ about(1, case.world.angle[0]), 1, 2) @ second.R
        turn = log(left)
        along = turn @ [np.cos(0.7), 0, np.sin(0.7)]
        assert np.allclose(turn - np.outer(along, [np.cos(0.7), 0, np.sin(0.7)]), 0, atol=1e-9)
        assert 0.02 < np.abs(along).max() <= 0.03 and along.std() > 0.008


def test_the_axis_couples_and_the_centre_moves_as_the_table_says():
    effects = [
        ("axis_coupling", "joint", {"coupling": [0.05, -0.03]}),
        ("moving_centre", "joint", {"slide": [0.01, 0.02, 0]}),
    ]
    case = build("hinge", effects, seed=1, noise=0.0, seconds=8.0)
    (first, second), q = case.world.segments, case.world.angle[0]
    assert np.allclose(second.R, first.R @ about(1, q) @ about(0, 0.05 * q) @ about(2, -0.03 * q))
    assert np.allclose(apply_back(first.R, second.p - first.p), np.outer(q, [0.01, 0.02, 0]), atol=1e-12)


def test_a_moving_centre_is_the_skin_of_imu1_sliding_the_other_way():
    """Exactly so once the base moves along: segment 1 is then drawn from the new centre."""
    slide, quiet = np.array([0.01, -0.02, 0.03]), {"noise": 0.0, "seconds": 8.0, "geometry_error": False}
    moving = build("hinge", [("moving_centre", "joint", {"slide": slide})], seed=9, **quiet)
    q, q1, q2 = moving.world.angle
    base = moving.world.segments[0].placed(np.outer(q, slide), np.outer(q1, slide), np.outer(q2, slide))
    assert np.allclose(base.p, moving.world.segments[1].p)  # the new segment 1 has the joint where segment 2 has it
    sliding = base.placed(moving.mounts[0].position - np.outer(q, slide), -np.outer(q1, slide), -np.outer(q2, slide))
    assert np.allclose(sliding.turned(moving.mounts[0].rotation).f, moving.tracks[0].f, atol=1e-12)


def test_axis_coupling_is_the_skin_of_imu2_to_first_order():
    quiet, errors = {"noise": 0.0, "seconds": 8.0, "geometry_error": False}, []
    for size in (0.02, 0.01):
        c = np.array([size, 0.0, -0.7 * size])
        coupled = build("hinge", [("axis_coupling", "joint", {"coupling": c[[0, 2]]})], seed=9, **quiet)
        mount = coupled.mounts[1]
        p = {"slide": np.cross(c, mount.position), "twist": mount.rotation.T @ c}
        skin = build("hinge", [("skin_sliding", "imu2", p)], seed=9, **quiet)
        errors.append(np.abs(skin.tracks[1].f - coupled.tracks[1].f).max())
    assert errors[0] < 0.05 and 3.5 < errors[0] / errors[1] < 4.5  # second order: a quarter for half the coupling


def test_the_encoder_follows_with_free_play():
    p = {"range": 0.03}
    case = build("hinge", [("backlash", "joint", p)], seed=1, noise=0.0, seconds=20.0, encoder=True)
    table = read_encoder(case.world, case.effects, case.options, case.seed)
    read = table["columns"]["angle"] + table["zero"]
    q = np.interp(table["columns"]["time"], case.world.t, case.world.angle[0])
    behind = read - q
    assert np.abs(behind).max() < 0.03 + 1e-4 and behind.max() > 0.029 and behind.min() < -0.029  # interpolation
    step = np.diff(q)
    engaged = (np.abs(behind[1:]) > 0.0299) & (np.abs(behind[:-1]) > 0.0299) & (np.abs(step) > 1e-4)
    assert np.array_equal(np.sign(step[engaged]), -np.sign(behind[1:][engaged]))  # it lags
    free = (np.abs(behind[1:]) < 0.028) & (np.abs(behind[:-1]) < 0.028)
    assert free.any() and np.abs(np.diff(read)[free]).max() < 1e-12  # and stands while the play is crossed

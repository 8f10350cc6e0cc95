"""Roll-outs by forces alone, against equations of motion integrated here; and what is rolled out of a swing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from imubench.diagnosis.config.simulation import ROLL_OUT
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.simulation import rollout
from imubench.diagnosis.simulation.rollout import horizon, refined, rolled_out
from imubench.diagnosis.simulation.swing_windows import free
from imubench.errors import InputError
from imubench.recording import Body, Encoder, Recording
from imubench.sim.dry_hinge import swing_dry_hinge
from imubench.sim.rigs import Mount, Segment, hinge, pendulum
from imubench.sim.swing import Start

G = 9.81
LIMB = Segment(1.3, np.array([0.004, -0.003, -0.2]), np.array([0.02, 0.018, 0.003]))


def hinge_like(**changes):
    """A hinge on a base that stands still, level, whose segment 2 is LIMB: it hangs at angle 0."""
    rig = hinge(base="fixed", **changes)
    return replace(rig, segments=(rig.segments[0], LIMB))


def by_equation(time, start, c=0.0, t=0.0, d=0.0, k=0.0, q0=0.0):
    """Angles (n,) rad of I q'' = m g (x cos q + z sin q) - c q' - t sign q' - d |q'| q' - k (q - q0), about +y.

    A rotation by q about y takes the com (x, z) to (x cos q + z sin q, z cos q - x sin q); the torque of the weight
    about y is m g times the first.
    """
    x, _, z = LIMB.com
    inertia = LIMB.inertia[1] + LIMB.mass * (x**2 + z**2)

    def slope(_, y, side):
        q, w = y
        weight = LIMB.mass * G * (x * np.cos(q) + z * np.sin(q))
        return [w, (weight - c * w - t * side - d * abs(w) * w - k * (q - q0)) / inertia]

    def stands(_, y, side):
        return y[1] * side

    stands.terminal, stands.direction = True, -1
    now, state, out = 0.0, np.array(start, dtype=float), np.empty(time.size)
    side = float(np.sign(state[1]))
    while True:  # between two reversals all is smooth
        said = solve_ivp(
            slope, (now, time[-1]), state, args=(side,), events=stands, dense_output=True, rtol=1e-10, atol=1e-12,
            max_step=0.02,
        )  # fmt: skip
        own = (time >= now) & (time <= said.t[-1])
        out[own] = said.sol(time[own])[0]
        if said.status == 0:
            return out
        now, state = said.t[-1], np.array([said.y[0, -1], 0.0])
        goes = [s for s in (1.0, -1.0) if slope(now, state, s)[1] * s > 0]
        if not goes:
            out[time > now] = state[0]
            return out
        side = goes[0]


@pytest.mark.parametrize(
    ("laws", "rig", "off"),
    [  # rad: MuJoCo's Runge and Kutta, in steps of 1 ms
        ({}, {}, 1e-6),
        ({"c": 0.02}, {"damping": 0.02}, 1e-6),
        ({"d": 0.01}, {"drag": 0.01}, 1e-5),
        ({"k": 0.8, "q0": 0.3}, {"stiffness": 0.8, "spring_angle": 0.3}, 1e-6),
        ({"t": 0.06}, {"dry_friction": 0.06}, 1e-6),
        ({"t": 0.05, "d": 0.01, "k": 0.8}, {"dry_friction": 0.05, "drag": 0.01, "stiffness": 0.8}, 1e-5),
        ({"t": 0.3}, {"dry_friction": 0.3}, 1e-6),  # it sticks
    ],
)
def test_a_hinge_swings_as_its_equation_says(laws, rig, off):
    swing = Swing(3.0, 11.0, Start(angle=1.4, angle_rate=-0.5))
    found = rolled_out(hinge_like(**rig), swing, 200.0)
    expected = by_equation(found.time - 3.0, [1.4, -0.5], **laws)
    assert found.time[0] == 3.0 and 11.0 < found.time[-1] < 11.02
    assert np.max(np.abs(found.hinge_angle - expected)) < off


def test_dry_friction_stops_a_swing_and_holds_it_there():
    found = rolled_out(hinge_like(dry_friction=0.3), Swing(0.0, 8.0, Start(angle=1.4)), 200.0)
    held = found.hinge_angle[found.time > 7.0]
    assert np.ptp(held) == 0.0
    assert LIMB.mass * G * 0.2 * abs(np.sin(held[0])) < 0.3 + 0.01  # N m: no more than friction holds


def test_what_friction_holds_moves_where_a_torque_exceeds_it():
    """From rest under 0.1 N m a second against 0.2 N m, the weight's 0.051 N m at angle 0 with it or against it."""
    rig, swing, weight = hinge_like(dry_friction=0.2), Swing(5.0, 9.0, Start()), LIMB.mass * G * LIMB.com[0]
    for side in (1.0, -1.0):
        found = rolled_out(rig, swing, 200.0, torque=lambda stamps, side=side: 0.1 * side * (stamps - 5.0))
        moves = found.time[np.flatnonzero(found.hinge_angle)[0]] - 5.0
        assert moves == pytest.approx((0.2 - side * weight) / 0.1, abs=6e-3)  # s: a row, and a step
        assert found.hinge_angle[-1] * side > 0.02


def test_a_roll_out_with_dry_friction_is_a_smooth_function_of_its_start_and_friction():
    """Differences of a hundredth say the same: where friction turns over at steps' ends they are off by a third."""
    rig, swing = hinge_like(dry_friction=0.05, drag=0.01), Swing(0.0, 6.0, Start(angle=1.4))

    def end(angle=0.0, friction=0.0):
        moved = replace(swing, state=replace(swing.state, angle=1.4 + angle))
        return rolled_out(replace(rig, dry_friction=0.05 + friction), moved, 200.0).hinge_angle[-1]

    for name in ("angle", "friction"):
        coarse, fine = ((end(**{name: h}) - end(**{name: -h})) / (2 * h) for h in (1e-4, 1e-6))
        assert fine == pytest.approx(coarse, rel=1e-4)  # the third derivative, h^2 of it


def test_friction_of_a_free_base_is_not_rolled_out():
    with pytest.raises(InputError, match="dry hinge: expected a hinge on a fixed base"):
        swing_dry_hinge(hinge(dry_friction=0.1), Start(), 10, 1, 1e-3)


def test_a_limb_on_a_ball_joint_swings_as_angular_momentum_says():
    """I w' + w x I w = c x m R' g - c w in segment axes, R' = R [w]; integrated here by itself."""
    com = LIMB.com
    inertia = np.diag(LIMB.inertia) + LIMB.mass * (com @ com * np.eye(3) - np.outer(com, com))

    def slope(_, y):
        q, w = y[:4] / np.linalg.norm(y[:4]), y[4:]
        down = Rotation.from_quat(q).inv().apply([0, 0, -G])
        accel = np.linalg.solve(inertia, np.cross(com, LIMB.mass * down) - 0.02 * w - np.cross(w, inertia @ w))
        turn = np.append(w, 0.0)
        x, s = q[:3], q[3]
        return np.concatenate([[*(0.5 * (s * turn[:3] + np.cross(x, w))), -0.5 * x @ w], accel])

    start = Rotation.from_rotvec([0.7, 0.4, 0.2])
    w = np.array([0.3, -1.0, 1.5])
    quaternion = start.as_quat()[[3, 0, 1, 2]]
    swing = Swing(0.0, 6.0, Start(quaternion=quaternion, rate=w))
    rig = replace(pendulum(damping=0.02), segments=(LIMB,))
    found = rolled_out(rig, swing, 200.0)
    y = solve_ivp(slope, (0, 6.1), [*start.as_quat(), *w], t_eval=found.time, rtol=1e-10, atol=1e-12).y
    apart = Rotation.from_quat(found.quaternion1[:, [1, 2, 3, 0]]).inv() * Rotation.from_quat(y[:4].T)
    assert np.max(apart.magnitude()) < 1e-5  # rad: both are of fourth order or better, over a damped swing


def test_sensors_weigh_nothing_and_springs_do_not_drive_a_swing():
    light, heavy = (
        hinge_like(mounts=(Mount(), Mount(position=np.array([0.1, 0, 0]), mass=mass))) for mass in (1e-3, 1.0)
    )
    swing = Swing(0.0, 3.0, Start(angle=1.0))
    both = [rolled_out(rig, swing, 100.0).hinge_angle for rig in (light, heavy)]
    np.testing.assert_array_equal(*both)


def test_a_long_swing_is_the_same_in_one_piece_and_in_many(monkeypatch):
    swing = Swing(0.0, 5.0, Start(angle=9.0, angle_rate=4.0))  # whole turns are counted
    rig = hinge_like(dry_friction=0.02)
    whole = rolled_out(rig, swing, 200.0).hinge_angle
    monkeypatch.setattr(rollout, "ROLL_OUT", replace(ROLL_OUT, chunk_s=0.7))
    assert whole[0] == pytest.approx(9.0, abs=1e-9)
    np.testing.assert_allclose(rolled_out(rig, swing, 200.0).hinge_angle, whole, atol=1e-9)  # rounding, in swings


def test_what_is_driven_is_not_rolled_out():
    with pytest.raises(InputError, match="roll-out: expected a base or a pivot that stands still"):
        rolled_out(hinge(), Swing(0.0, 2.0, Start()), 100.0)


def misfit_of(rig, truth, noise, step=0.01):
    """A misfit of a limb that shows its rates, or its angle, against a truth that is rolled out itself."""

    def seen(swing):
        played = rolled_out(rig, swing, 1 / step)
        if played.hinge_angle is not None:
            return played.time, played.hinge_angle[:, None]
        q = Rotation.from_quat(played.quaternion1[:, [1, 2, 3, 0]])
        return played.time, np.stack([q.apply(axis) for axis in np.eye(3)], axis=1).reshape(len(q), 9)

    _, measured = seen(truth)

    def misfit(swing):
        time, values = seen(swing)
        n = min(len(values), len(measured))
        return np.tile(time[:n], values.shape[1]), ((values[:n] - measured[:n]) / noise).T.ravel()

    return misfit


@pytest.mark.parametrize("family", ["hinge", "pendulum"])
def test_the_start_of_a_swing_is_found_from_its_first_second(family):
    rig = hinge_like() if family == "hinge" else replace(pendulum(), segments=(LIMB,))
    turned = Rotation.from_rotvec([0.7, 0.4, 0.2]).as_quat()[[3, 0, 1, 2]]
    true = Swing(0.0, 5.0, Start(angle=1.2, angle_rate=0.4, quaternion=turned, rate=np.array([0.3, -1.0, 1.5])))
    near = replace(
        true,
        state=rollout.state_beside(rig, true.state, 0.02 * np.array([1, -1, 1, 1, -1, 1])[: rollout.freedoms(rig)]),
    )
    found = refined(rig, near, misfit_of(rig, true, 1e-3)).state
    off = [found.angle - 1.2, found.angle_rate - 0.4] if family == "hinge" else found.rate - true.state.rate
    assert np.max(np.abs(off)) < 1e-5  # rad/s: Newton's third step from 0.02 away


@pytest.mark.long
def test_the_horizon_is_a_chaotic_limbs_and_no_hinges():
    """A limb that almost stands on its head, twice: the way it falls is told by what no sensor sees."""
    rig = replace(pendulum(), segments=(LIMB,))
    wild = Swing(
        0.0, 12.0, Start(quaternion=Rotation.from_rotvec([2.9, 0.1, 0]).as_quat()[[3, 0, 1, 2]], rate=[0, 0.2, 2.0])
    )
    calm = replace(wild, state=Start(quaternion=Rotation.from_rotvec([0.2, 0.1, 0]).as_quat()[[3, 0, 1, 2]]))
    until = horizon(rig, wild, misfit_of(rig, wild, 1e-3))
    assert 1.5 <= until < 12.0
    assert horizon(rig, calm, misfit_of(rig, calm, 1e-3)) == 12.0
    arm = Swing(0.0, 12.0, Start(angle=3.0))
    assert horizon(hinge_like(), arm, misfit_of(hinge_like(), arm, 1e-3)) == 12.0


def test_what_a_hand_holds_is_not_rolled_out():
    """An arm that is held at 1 rad for 2 s, swings, and is caught at 0.7 rad, all within the declared window."""
    time = np.arange(0.0, 9.0, 5e-3)
    swung = by_equation(np.arange(0.0, 5.0, 5e-3), [1.0, 0.0], c=0.01)
    last = np.flatnonzero((swung[:-1] < 0.7) & (swung[1:] >= 0.7))[-1]
    angle = np.concatenate([np.full(400, 1.0), swung[:last], np.full(time.size - 400 - last, 0.7)])
    angle += 2e-5 * np.random.default_rng(0).normal(size=time.size)
    body = Body(LIMB.mass, LIMB.com, LIMB.inertia)
    recording = Recording(
        *("held", "hinge"), encoders=(Encoder("hinge", time, angle),), base="fixed", body=body, motion="free",
        free_swings=((0.0, float(time[-1])),),
    )  # fmt: skip
    (window,) = free(nominal_fit(recording))
    let_go, stopped = 2.0, 2.0 + last * 5e-3
    assert (
        let_go <= window[0] < let_go + 0.2
    )  # s: an arm at 1 rad moves by 0.3 rad/s within 0.01 s; the rate is smoothed
    assert stopped - 0.6 < window[1] <= stopped  # s: a hand takes some tenths


def test_what_rests_by_friction_is_rolled_out(swung):
    """An arm that hangs still at the end of its swing is held by nobody."""
    recording = swung({"dry_friction": 0.05}, 9.0)
    (window,) = free(nominal_fit(recording), friction=0.05)
    assert window == pytest.approx(recording.free_swings[0])

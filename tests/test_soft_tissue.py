"""The three kinds of soft tissue against the paper's equation and against Newton."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.errors import InputError
from imubench.scenarios.pendulum import R_AMPLITUDE, R_CAPTIONS, R_TEXT, ellipse, limb
from imubench.sim.play import play
from imubench.sim.rigs import Mount, springs
from imubench.sim.signals import STILL

EXACT = 1e-9  # as in test_play.py
GRAVITY_W = np.array([0.0, 0.0, -9.81])


def parts(jets, time):
    """Matrix R with its derivatives, and the paper's r(t) with its own, all by hand."""
    R, dR, ddR = jets(ellipse(), time).R1
    w = 2 * np.pi
    r = R_TEXT + R_AMPLITUDE * np.sin(w * time)[:, None]
    dr = R_AMPLITUDE * w * np.cos(w * time)[:, None]
    return R, dR, ddR, r, dr, -(w**2) * (r - R_TEXT)


def test_paper_leaves_the_sensors_own_acceleration_out(jets):
    truth = play(limb("paper"), ellipse(), 3.0, 200.0)
    R, _, ddR, r, _, _ = parts(jets, truth.time)
    sensor = truth.sensors[0]
    assert_allclose(sensor.joint_vector, r, atol=EXACT)
    force = np.einsum("nji,nj->ni", R, np.einsum("nij,nj->ni", ddR, -r) - GRAVITY_W)
    assert_allclose(sensor.specific_force, force, atol=EXACT)


def test_sliding_is_the_second_derivative_of_where_the_sensor_is(jets):
    truth = play(limb("sliding"), ellipse(), 3.0, 200.0)
    R, dR, ddR, r, dr, ddr = parts(jets, truth.time)
    sensor = truth.sensors[0]
    assert_allclose(sensor.joint_vector, r, atol=EXACT)
    acceleration = sum(np.einsum("nij,nj->ni", m, -x) for m, x in ((ddR, r), (2 * dR, dr), (R, ddr)))
    assert_allclose(sensor.acceleration, acceleration, atol=EXACT)
    assert_allclose(sensor.specific_force, np.einsum("nji,nj->ni", R, acceleration - GRAVITY_W), atol=EXACT)


def test_what_paper_leaves_out_is_as_large_as_what_it_keeps():
    paper, sliding = (play(limb(kind), ellipse(), 3.0, 200.0).sensors[0] for kind in ("paper", "sliding"))
    left_out = np.sqrt(np.mean((sliding.specific_force - paper.specific_force) ** 2))
    # 20 mm at 1 Hz: (2 pi)^2 0.02 / sqrt 2 = 0.56 m/s^2 RMS along x and z, and Coriolis terms on top.
    assert 0.3 < left_out < 1.0


def test_gyroscopes_do_not_see_a_slide():
    rigid, sliding = (play(limb(kind), ellipse(), 1.0, 200.0).sensors[0] for kind in ("none", "sliding"))
    assert_allclose(rigid.gyro, sliding.gyro, atol=EXACT)
    assert_allclose(rigid.joint_vector, np.broadcast_to(R_TEXT, (200, 3)), atol=EXACT)


def test_sprung_moves_along_and_about():
    sensor = play(limb("sprung"), ellipse(), 3.0, 200.0).sensors[0]
    assert 1e-3 < np.ptp(sensor.displacement, axis=0).max() < 0.05
    assert np.ptp(sensor.rotation, axis=0).max() > 1e-3


def test_both_readings_of_r_can_be_had():
    for r in (R_TEXT, R_CAPTIONS):
        assert_allclose(play(limb(r=r), ellipse(), 0.1).sensors[0].joint_vector[0], r, atol=EXACT)


def test_amplitudes_and_periods_are_the_papers():
    time = np.linspace(0, 3, 3001)
    motion = ellipse()
    for signal, degrees, period in ((motion.tilt, 17, 1.0), (motion.spin, 9, 1.0), (motion.heading, 3, 1.5)):
        value = signal(time)[0]
        assert np.rad2deg(value.max()) == pytest.approx(degrees, rel=1e-4)
        assert_allclose(
            value[time + period <= 3], value[time >= period - 1e-12][: (time + period <= 3).sum()], atol=1e-9
        )


def test_nonsense_is_refused():
    with pytest.raises(InputError, match="unknown soft tissue 'slidng'; known: none, paper, sliding, sprung"):
        limb("slidng")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="springs or a prescribed path, got both"):
        Mount(path=(STILL, STILL, STILL), translation=springs(5.0, 0.1))

"""Mounts that slip once or slide with the joint, and pivots that move: where laws have them, what sensors read."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.dataset import make, parse_spec
from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, Slip, springs
from imubench.sim.signals import Sines
from imubench.sim.swing import Start, swing

SLIDE, TWIST = np.array([0.02, -0.01, 0.015]), np.array([0.1, -0.2, 0.05])
SLIP = Slip(0.4, np.array([0.01, 0.02, -0.03]), np.array([0.2, 0.1, -0.3]))
KINDS = {"slip": {"slip": SLIP}, "slide": {"slide": SLIDE, "twist": TWIST}, "twist": {"twist": TWIST}}
KINDS["both"] = KINDS["slip"] | KINDS["slide"]
WAYS = {
    "hinge": {"heading": 1.0, "tilt": 0.4, "spin": 0.8, "angle": 0.7, "x": 0.1},
    "pendulum": {"tilt": 0.4, "spin": 0.9},
}


def rig_of(family: str, **kind: object) -> rigs.Rig:
    mount = Mount(np.array([0.1, 0.02, 0.03]), rotations.exp(np.array([0.4, -1.0, 0.3])), **kind)
    return rigs.hinge(mounts=(Mount(), mount)) if family == "hinge" else rigs.pendulum(mounts=(mount,))


def motion_of(family: str) -> AngleMotion:
    return AngleMotion(**{key: Sines(a, 0.7 + 0.1 * i, i) for i, (key, a) in enumerate(WAYS[family].items())})


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("family", WAYS)
def test_sensors_read_how_they_move(family, kind):
    """Differences of position and attitude, of order 2, against the readings."""
    h = 2e-4
    truth = play(rig_of(family, **KINDS[kind]), motion_of(family), 0.8, 1 / h)
    sensor = truth.sensors[-1]
    second = np.diff(sensor.position, 2, axis=0) / h**2
    force = rotations.rotate_back(sensor.quaternion[1:-1], second + np.array([0, 0, 9.81]))
    q = sensor.quaternion
    rate = rotations.log(rotations.multiply(rotations.conjugate(q[:-2]), q[2:])) / (2 * h)
    # At both ends of the slip the jerk jumps by 60 * 0.03 / 0.2^3 = 225 m/s^3: h / 6 of it.
    assert_allclose(sensor.specific_force[1:-1], force, atol=1e-2)
    assert_allclose(sensor.gyro[1:-1], rate, atol=5e-4)
    turning = np.gradient(sensor.gyro, h, axis=0)[1:-1]
    # Its derivative jumps there by 60 * 0.36 / 0.2^3 = 2700 rad/s^3: h / 4 of it.
    assert_allclose(sensor.angular_acceleration[1:-1], turning, atol=0.15)


@pytest.mark.parametrize("size", [1e-15, 1e-200])
@pytest.mark.parametrize("family", WAYS)
def test_what_hardly_moves_is_as_what_does_not(family, size):
    """Numbers that a fit leaves of a slip that its half of a recording does not hold, say."""
    slip = Slip(0.4, size * SLIP.translation, size * SLIP.rotation)
    hardly = play(rig_of(family, slip=slip, slide=size * SLIDE, twist=size * TWIST), motion_of(family), 0.8, 100.0)
    still = play(rig_of(family), motion_of(family), 0.8, 100.0)
    assert_allclose(hardly.sensors[-1].specific_force, still.sensors[-1].specific_force, atol=1e-9)
    assert_allclose(hardly.sensors[-1].gyro, still.sensors[-1].gyro, atol=1e-9)


@pytest.mark.parametrize("family", WAYS)
def test_mounts_are_where_the_laws_have_them(family):
    """exp(slip) and then exp(twist angle), the swing of a pendulum being atan2(R[0, 2], R[2, 2])."""
    truth = play(rig_of(family, **KINDS["both"]), motion_of(family), 1.0, 100.0)
    sensor = truth.sensors[-1]
    R = rotations.to_matrix(truth.segments[0].quaternion)
    angle = truth.joint_angle if family == "hinge" else np.arctan2(R[:, 0, 2], R[:, 2, 2])
    assert np.ptp(angle) > 0.5
    u = np.clip((truth.time - SLIP.time) / 0.2, 0.0, 1.0)
    gone = u**3 * (10 - 15 * u + 6 * u**2)
    moved = np.outer(angle, SLIDE) + np.outer(gone, SLIP.translation)
    turned = rotations.multiply(rotations.exp(np.outer(gone, SLIP.rotation)), rotations.exp(np.outer(angle, TWIST)))
    # Rotations of 0.4 rad taken apart and put together again.
    assert_allclose(sensor.displacement, moved, atol=1e-12)
    assert_allclose(sensor.rotation, rotations.log(turned), atol=1e-12)


def test_a_mount_that_does_not_move_reads_as_a_rigid_one():
    still, rigid = (
        play(rig_of("hinge", **kind), motion_of("hinge"), 0.4, 100.0).sensors[1] for kind in ({"slip": Slip(9.0)}, {})
    )
    assert_allclose(still.specific_force, rigid.specific_force, atol=1e-10)  # another model, the same physics
    with pytest.raises(InputError, match="expected springs or a prescribed path, got both"):
        rig_of("hinge", path=(Sines(), Sines(), Sines()), rotation=springs(10.0, 0.1))


@pytest.mark.parametrize("name", ["skin_sliding", "mount_shift"])
def test_datasets_draw_them_for_rigs_that_can(name):
    text = (
        "seconds = 10\nrecordings_per_rig = 1\n[[effect]]\nname = '{}'\nat = 'imu1'\n" + "[[rig]]\nfamily = '{}'\n" * 3
    )
    spec = parse_spec({"spec.toml": text.format(name, "hinge", "pendulum", "free").encode()})
    seen = set()
    for index in range(12):
        made = make(spec, 0, index)
        family, (shown, moved) = made.drawn.rig.family, (len(made.drawn.effects), made.truth.sensors[0].displacement)
        seen.add(family)
        assert shown == (family != "free" or name == "mount_shift")
        assert bool(shown) == bool(np.abs(moved).max() > 1e-4)
        for e in made.drawn.effects:
            assert "time" not in e["parameters"] or 1.0 <= e["parameters"]["time"] <= 9.0
    assert seen == {"hinge", "pendulum", "free"}


def test_a_dataset_has_mounts_that_slip_on_their_springs():
    text = (
        "seconds = 4\n[[rig]]\nfamily = 'hinge'\nsoft_probability = 1\n[[effect]]\nname = 'mount_shift'\nat = 'imu2'\n"
    )
    made = make(parse_spec({"spec.toml": text.encode()}), 0, 0)
    slip = made.drawn.rig.mounts[1].slip
    assert slip is not None and made.drawn.rig.mounts[1].sprung
    moved = made.truth.sensors[1].displacement
    before, after = (moved[time] for time in (made.truth.time < slip.time, made.truth.time > slip.time + 0.2))
    # Springs of 5 Hz and more sag by 1 cm at most; means over half a second and more differ by less than that.
    assert np.linalg.norm(after.mean(axis=0) - before.mean(axis=0) - slip.translation) < 0.02


def test_a_pivot_moves_as_its_law_says_and_the_sensor_feels_it():
    text = (
        "seconds = 60\n[[rig]]\nfamily = 'pendulum'\n{}[[effect]]\nname = 'moving_pivot'\nstd = 0.4\nband = [0.5, 3]\n"
    )
    made = make(parse_spec({"spec.toml": text.format("").encode()}), 0, 0)
    (effect,), pivot = made.drawn.effects, made.truth.segments[0]
    low, high = effect["parameters"]["band"]
    # 30 lines beat: over 60 s the square of their sum is its mean within a tenth.
    assert pivot.acceleration.std(axis=0) == pytest.approx([0.4] * 3, rel=0.1)
    power = np.abs(np.fft.rfft(pivot.acceleration * np.hanning(6000)[:, None], axis=0)) ** 2
    inside = (np.fft.rfftfreq(6000, 0.01) > low - 0.05) & (np.fft.rfftfreq(6000, 0.01) < high + 0.05)
    assert power[inside].sum() > 0.999 * power.sum()
    for springs_under in ("", "rocking = { frequency = 15 }\n"):
        drawn = make(parse_spec({"spec.toml": text.format(springs_under).encode()}), 0, 0).drawn
        sensor = play(drawn.rig, drawn.motion, 0.5, 2000.0).sensors[0]
        second = np.diff(sensor.position, 2, axis=0) * 2000.0**2
        force = rotations.rotate_back(sensor.quaternion[1:-1], second + np.array([0, 0, 9.81]))
        assert_allclose(sensor.specific_force[1:-1], force, atol=2e-3)  # h^2 / 12 of a fourth derivative of 1e5 m/s^4
    with pytest.raises(InputError, match="expected a pendulum for a pivot that moves"):
        rigs.hinge(pivot_moves=True)
    with pytest.raises(InputError, match="swing: expected joints that gravity and torques move"):
        swing(rigs.pendulum(pivot_moves=True), Start(), 1.0)

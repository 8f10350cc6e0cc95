"""Free swings in datasets: they obey the declared body and the laws of their effects, and come back as free."""

import numpy as np
import pytest

from imubench import rotations
from imubench.dataset import make, parse_spec, read
from imubench.dataset.generate import generate
from imubench.dataset.shard import Job
from imubench.errors import InputError

HINGE = "seconds = 5\nrecordings_per_rig = 1\n[[rig]]\nfamily = 'hinge'\nbase = 'fixed'\n[[motion]]\nkind = 'swing'\n"
PENDULUM = HINGE.replace("'hinge'\nbase = 'fixed'", "'pendulum'")
TORQUES = {  # the numbers, and the torque for them at rates and angles
    "viscous_friction": ("c = 0.01", lambda p, w, q: -p["c"] * w),
    "dry_friction": ("t = 0.002", lambda p, w, q: -p["t"] * np.sign(w)),
    "air_drag": ("d = 0.01", lambda p, w, q: -p["d"] * np.abs(w) * w),
    "joint_spring": ("k = 0.4\nq0 = 0.5", lambda p, w, q: -p["k"] * (q - p["q0"])),
}


def spec_of(text: str):
    return parse_spec({"spec.toml": text.encode()})


def effect(name: str, numbers: str) -> str:
    return f"[[effect]]\nname = '{name}'\n{numbers}\n"


def about_joint(body) -> np.ndarray:
    """The declared body's inertia (3, 3) about the joint."""
    return np.diag(body.inertia) + body.mass * (body.com @ body.com * np.eye(3) - np.outer(body.com, body.com))


def unexplained(made) -> tuple[np.ndarray, np.ndarray]:
    """Torques (n, 3) that neither the declared body nor gravity accounts for, segment axes, and the rates (n, 3)."""
    body, segment = made.recording.body, made.truth.segments[-1]
    inertia, w = about_joint(body), segment.rate
    weight = rotations.rotate_back(segment.quaternion, [0.0, 0.0, -made.truth.gravity * body.mass])
    return segment.angular_acceleration @ inertia + np.cross(w, w @ inertia) - np.cross(body.com, weight), w


@pytest.mark.parametrize("name", TORQUES)
def test_a_hinge_swings_by_the_law_of_its_torque(name):
    numbers, law = TORQUES[name]
    spec = spec_of(HINGE + effect(name, numbers))
    for index in range(3):
        made = make(spec, 1, index)
        torque, w = unexplained(made)
        (found,) = made.drawn.effects
        w = w[:, 1]
        expected = law(found["parameters"], w, made.truth.joint_angle)
        # The sensor's own mass of a millionth of a kilogram; dry friction turns over within some steps of 2 ms.
        turning = 0.005 * np.abs(made.truth.segments[1].angular_acceleration[:, 1])
        moving = np.abs(w) > (turning if name == "dry_friction" else -1.0)
        assert moving.sum() > 50
        assert np.abs(torque[:, 1] - expected)[moving].max() < 1e-5
        assert np.abs(expected).max() > 1e-3


@pytest.mark.parametrize("text", [HINGE, PENDULUM], ids=["hinge", "pendulum"])
def test_without_effects_gravity_and_the_declared_body_say_it_all(text):
    for index in range(4):
        made = make(spec_of(text), 2, index)
        axes = [1] if text == HINGE else [0, 1, 2]
        assert np.abs(unexplained(made)[0][:, axes]).max() < 1e-5  # the sensor's millionth of a kilogram
        assert np.abs(made.truth.segments[-1].rate).max() > 1.0


def test_friction_takes_a_pendulums_energy_and_a_scaled_inertia_is_believed_and_not_true():
    made = make(spec_of(PENDULUM + effect("viscous_friction", "c = 0.02")), 0, 0)
    torque, w = unexplained(made)
    assert np.abs(torque + 0.02 * w).max() < 1e-5
    plain, scaled = (make(spec_of(PENDULUM + e), 0, 0) for e in ("", effect("inertia", "scale = 1.2")))
    assert np.array_equal(plain.recording.imus[0].gyro, scaled.recording.imus[0].gyro)
    ratio = about_joint(scaled.recording.body)[0, 0] / about_joint(plain.recording.body)[0, 0]
    assert ratio == pytest.approx(1.2)  # m l / I is 1.2 times what it says


def test_what_is_stored_comes_back_as_a_free_swing(tmp_path):
    text = PENDULUM + "[[motion]]\nkind = 'random'\n" + effect("viscous_friction", "c = 0.01")
    generate(Job({"spec.toml": text.encode()}, 0, 8, str(tmp_path / "d")), 0)
    kinds = set()
    for index in range(8):
        stored, made = read(tmp_path / "d", index), make(spec_of(text), 0, index).recording
        assert (stored.recording.motion, stored.recording.free_swings) == (made.motion, made.free_swings)
        assert (stored.recording.body is None) == (made.motion == "hand")
        if made.body is not None:
            assert made.free_swings == ((0.0, 5.0),)
            assert np.array_equal(stored.recording.body.inertia, made.body.inertia)
        assert bool(stored.effects) == (made.motion == "free")  # friction shows in free swings alone
        kinds.add(made.motion)
    assert kinds == {"free", "hand"}


def test_torques_without_a_swing_and_swings_of_a_free_rig_are_refused():
    hand = "[[rig]]\nfamily = 'pendulum'\n" + effect("air_drag", "")
    with pytest.raises(InputError, match="air_drag: expected a motion of kind 'swing', which it shows in, got none"):
        spec_of(hand)
    with pytest.raises(InputError, match="expected a motion that a free hinge can do, got swing"):
        spec_of(HINGE.replace("base = 'fixed'\n", ""))


@pytest.mark.parametrize("family", ["hinge", "pendulum"])
def test_a_swing_ends_at_its_stop(family):
    base = "base = 'fixed'\n" if family == "hinge" else ""
    effect = "[[effect]]\nname = 'end_stop'\nangle = 0.3\n"
    spec = parse_spec(
        {"spec.toml": f"seconds = 4\n[[rig]]\nfamily = '{family}'\n{base}[[motion]]\nkind = 'swing'\n{effect}".encode()}
    )
    made = make(spec, 0, 0)
    (found,) = made.drawn.effects
    stop = found["parameters"]["angle"]
    if family == "hinge":
        q = made.truth.joint_angle
    else:
        z = rotations.to_matrix(made.truth.segments[0].quaternion)[:, :, 2]
        q = np.arctan2(z[:, 0], z[:, 2])
    deepest = np.max(np.sign(stop) * (q - stop))
    # It comes with 4 to 6 rad/s, and bounces at 25 Hz = 157 rad/s: 0.04 rad without a damper.
    assert 0.0 < deepest < 0.05

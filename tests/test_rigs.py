"""Rigs as numbers: what they refuse, and that MuJoCo gets what was asked for."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.compile import compile_model
from imubench.sim.rigs import Mount, Segment, springs


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Mount(quaternion=np.array([1.0, 1, 0, 0])), "expected a unit quaternion"),
        (lambda: Mount(position=np.zeros(2)), "expected shape"),
        (lambda: Mount(com=np.array([0.02, 0, 0])), "expected less than 0.0105 m from the pivot"),
        (lambda: Mount(mass=-1.0), "mount.mass: expected a number > 0"),
        (lambda: springs(0.0, 0.1), "expected frequencies > 0"),
        (lambda: Segment(1.0, np.zeros(3), np.array([1.0, 1.0, 3.0])), "moments that a body can have"),
        (lambda: rigs.hinge(mounts=()), "expected 2 segments and one mount each"),
        (lambda: rigs.pendulum(base="fixed"), "expected a hinge"),
        (lambda: rigs.hinge(gravity=float("nan")), "gravity: expected a number >= 0"),
        (lambda: rigs.Rig("pendulm", (), ()), "unknown rig 'pendulm'; known: hinge, pendulum, free"),
    ],
)
def test_bad_rigs_are_refused_with_a_reason(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_masses_geometry_and_mounts_reach_the_model():
    rig = rigs.random_hinge(np.random.default_rng(0))
    model = compile_model(rig)
    for i, (segment, mount) in enumerate(zip(rig.segments, rig.mounts, strict=True)):
        body, imu = model.body(f"segment{i + 1}"), model.body(f"imu{i + 1}")
        assert_allclose(body.mass, segment.mass)
        assert_allclose(body.ipos, segment.com, atol=1e-12)
        assert_allclose(np.sort(body.inertia), np.sort(segment.inertia), rtol=1e-9)
        assert_allclose(imu.pos, mount.position, atol=1e-12)
        assert_allclose(np.abs(imu.quat @ mount.quaternion), 1.0)
        assert_allclose(imu.mass, mount.mass)


def test_springs_have_the_asked_frequency_and_damping():
    mount = Mount(
        translation=springs(np.array([5.0, 6.0, 7.0]), 0.1), rotation=springs(8.0, 0.2), mass=0.02, gyration=0.01
    )
    model = compile_model(rigs.free(mounts=(mount,)))
    slides = [model.joint(f"imu1_slide_{a}") for a in "xyz"]
    assert_allclose([np.sqrt(j.stiffness[0] / 0.02) / (2 * np.pi) for j in slides], [5, 6, 7])
    assert_allclose([j.damping[0] / (2 * np.sqrt(j.stiffness[0] * 0.02)) for j in slides], 0.1)
    turns = [model.joint(f"imu1_hinge_{a}") for a in "xyz"]
    assert_allclose([np.sqrt(j.stiffness[0] / 2e-6) / (2 * np.pi) for j in turns], 8.0)


def test_one_imu_is_enough():
    model = compile_model(rigs.hinge(mounts=rigs.hinge().mounts[:1]))
    assert model.nsensor == 2 * 6 + 6

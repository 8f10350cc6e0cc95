"""MuJoCo Warp against MuJoCo: the same samples within single precision; without the extra, one line."""

import sys

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.rigs import Mount, Slip, springs

TOLERANCES = {  # of the greatest value; single precision is 6e-8, and an acceleration is a sum of larger ones
    "position": 1e-6,
    "quaternion": 1e-6,
    "gyro": 2e-6,
    "specific_force": 2e-5,
    "acceleration": 2e-5,
    "angular_acceleration": 5e-5,
}
RIGS = {
    "hinge": rigs.hinge(),
    "pendulum": rigs.pendulum(),
    "free": rigs.free(),
    "sprung": rigs.hinge(mounts=(Mount(), Mount(np.array([0.1, 0, 0.03]), rotation=springs(12.0, 0.2)))),
    "slipping": rigs.hinge(mounts=(Mount(), Mount(np.array([0.1, 0, 0.03]), slip=Slip(1.0, np.full(3, 0.01))))),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGS)
def test_warp_reads_what_mujoco_reads(name, random_motion):
    pytest.importorskip("mujoco_warp", reason="needs the extra: pip install 'imubench[warp]'")
    ours, theirs = (play(RIGS[name], random_motion(3), 3.0, 100.0, engine=e) for e in ("mujoco", "warp"))
    for one, other in zip(ours.sensors, theirs.sensors, strict=True):
        for key, tolerance in TOLERANCES.items():
            expected, found = getattr(one, key), getattr(other, key)
            assert np.abs(found - expected).max() < tolerance * np.abs(expected).max(), key


def test_without_the_extra_one_line_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco_warp", None)
    with pytest.raises(InputError, match=r"engine 'warp': expected the extra, pip install 'imubench\[warp\]'"):
        play(rigs.free(), AngleMotion(), 0.1, 100.0, engine="warp")
    with pytest.raises(InputError, match="unknown engine 'jax'; known: mujoco, warp"):
        play(rigs.free(), AngleMotion(), 0.1, 100.0, engine="jax")

"""A rig is written as MJCF and read back: every number that it has is in the file."""

from dataclasses import fields

import numpy as np
import pytest

from imubench import rotations
from imubench.correction.rig_file import read_rig
from imubench.errors import InputError
from imubench.sim import rigs
from imubench.sim.compile import specify
from imubench.sim.joints import Play, Stop
from imubench.sim.rigs import Mount, Slip, springs

LOOSE = Mount(
    np.array([0.1, 0.02, 0.03]),
    rotations.exp(np.array([0.4, -1.0, 0.3])),
    translation=springs(9.0, 0.1),
    rotation=springs([9.0, 10, 11], [0.1, 0.2, 0.3]),
    com=np.array([0.001, 0.002, 0.003]),
    lever=np.array([0.01, 0.02, 0]),
    slip=Slip(0.4, np.array([0.01, 0.02, -0.03]), np.array([0.2, 0.1, -0.3])),
    slide=np.array([0.02, -0.01, 0.015]),
    twist=np.array([0.1, -0.2, 0.05]),
)
TORQUES = {"drag": 0.1, "damping": 0.2, "dry_friction": 0.05, "stiffness": 0.7, "spring_angle": 0.2}
RIGS = {
    "hinge": rigs.hinge(
        mounts=(Mount(), LOOSE),
        coupling=np.array([0.1, -0.2]),
        centre=np.array([0.02, -0.01, 0.015]),
        play=Play(0.03, 0.7, 5.0, 0.2, 0.5),
        stop=Stop(-0.6, 80.0, 0.3),
        inertia_scale=1.3,
        **TORQUES,
    ),
    "loose hinge on a fixed base": rigs.hinge(play=Play(0.03, -2.0), base="fixed", stop=Stop(0.6)),
    "pendulum": rigs.pendulum(
        mounts=(LOOSE,), stop=Stop(-0.6, 80.0, 0.3), spring_conserves=True, inertia_scale=0.8, **TORQUES
    ),
    "pendulum on a moving pivot": rigs.pendulum(pivot_moves=True),
    "free": rigs.free(),
}


def numbers(part, name=""):
    """Every number of a rig by its name, pictures apart."""
    if hasattr(part, "__dataclass_fields__"):
        for f in fields(part):
            if f.name != "length":
                yield from numbers(getattr(part, f.name), f"{name}.{f.name}")
    elif isinstance(part, tuple):
        for i, one in enumerate(part):
            yield from numbers(one, f"{name}[{i}]")
    else:
        yield name, part


@pytest.mark.parametrize("name", RIGS)
def test_a_rig_comes_back_as_it_was(name, tmp_path):
    rig, path = RIGS[name], tmp_path / "rig.xml"
    spec = specify(rig)
    spec.compile()
    path.write_text(spec.to_xml())
    read = dict(numbers(read_rig(path, rig.family)))
    for key, value in numbers(rig):
        if value is None or isinstance(value, str | bool):
            assert read[key] == value, key
        else:  # the file has six digits, of which some are lost in differences of inertias
            np.testing.assert_allclose(np.asarray(read[key], float), value, rtol=2e-4, atol=1e-6, err_msg=key)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('data="0.4 0.01', 'data="0.01', r"rig\.xml: numeric 'imu1_slip': expected 7 numbers, got 6"),
        ('data="-0.6 80 0.3"', 'data="-0.6 80"', r"rig\.xml: numeric 'end_stop': expected 3 numbers, got 2"),
        ('data="-0.6 80 0.3"', 'data="-0.6 -80 0.3"', r"rig\.xml: stop\.stiffness: expected"),
    ],
)
def test_a_damaged_law_is_one_line(old, new, message, tmp_path):
    spec = specify(RIGS["pendulum"])
    spec.compile()
    text = spec.to_xml().replace('size="7" ', "").replace('size="3" ', "")
    assert old in text
    path = tmp_path / "rig.xml"
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message) as error:
        read_rig(path, "pendulum")
    assert "\n" not in str(error.value)

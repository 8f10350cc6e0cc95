"""Two and three effects at once, made by the independent generator: each is named at its place, and nothing else."""

import pytest

from imubench.diagnosis.pipeline import diagnose
from imubench.format1 import read
from imubench.proof.case import build
from imubench.proof.filed import write
from imubench.proof.told import truth
from imubench.trials.make import answers
from imubench.trials.match import paired, sure

pytestmark = pytest.mark.slow

SWING = {"base": "fixed", "swing": True}
TWO = [
    ("hinge", ("gyro_bias", "imu1"), ("accel_scale", "imu2"), {}),
    ("hinge", ("rocking_mount", "imu2"), ("accel_bias", "imu1"), {}),
    ("hinge", ("low_pass", "imu1"), ("axis_coupling", "joint"), {}),
    ("hinge", ("dry_friction", "joint"), ("gyro_scale", "imu2"), SWING),
    ("hinge", ("time_offset", "imu2"), ("mount_shift", "imu1"), {}),
    ("hinge", ("joint_play", "joint"), ("gyro_misalignment", "imu1"), {}),
    ("hinge", ("backlash", "joint"), ("accel_bias", "imu2"), {"base": "fixed", "encoder": True}),
    ("pendulum", ("moving_pivot", "joint"), ("accel_scale", "imu1"), {}),
    ("pendulum", ("air_drag", "joint"), ("inertia", "body"), {"swing": True}),
    ("free", ("vibration", "imu1"), ("gyro_drift", "imu1"), {}),
]
THREE = [
    ("hinge", ("joint_spring", "joint"), ("viscous_friction", "joint"), ("gyro_scale", "imu2"), SWING),
    ("hinge", ("low_pass", "imu1"), ("gyro_bias", "imu1"), ("axis_coupling", "joint"), {}),
    ("hinge", ("accel_bias", "imu1"), ("clock_skew", "imu2"), ("skin_sliding", "imu2"), {"encoder": True}),
    ("hinge", ("soft_mount", "imu1"), ("gyro_bias", "imu2"), ("impacts", "imu2"), {}),
    ("pendulum", ("g_sensitivity", "imu1"), ("accel_misalignment", "imu1"), ("gyro_noise", "imu1"), {}),
    ("free", ("time_offset", "imu1"), ("accel_drift", "imu1"), ("quantisation", "imu1"), {}),
]


OPEN = {"moving_pivot+accel_scale": "a pivot may accelerate one way for ever, and takes what the scale adds"}


def parameter(case):
    name = "+".join(e[0] for e in case[1:-1])
    marks = [pytest.mark.xfail(reason=OPEN[name], strict=True)] if name in OPEN else []
    return pytest.param(case, id=name, marks=marks)


@pytest.mark.parametrize("case", [parameter(c) for c in TWO + THREE])
def test_each_of_several_effects_is_named(case, tmp_path):
    rig, *effects, options = case
    made = build(rig, effects, 40 + len(effects), seconds=25.0, **options)
    write(made, tmp_path / "r")
    right = truth(made) | {"answers": [answers(e, made.options) for e in made.effects]}
    found = sure(diagnose(read(tmp_path / "r")[0])[0].findings)
    assert len(paired(right, found)) == len(effects) == len(found), [(f.effect, f.at) for f in found]

"""Every effect of the table, made by the independent generator, is found, named, placed and measured.

Recordings of 25 s with one effect of a middling size each, the rest as a recording is: mounts off by what is declared,
noise of its own. A number counts as right within 10 % or three of the stated standard deviations; 95 % of the excess
misfit must be gone. A weak or a strong one must be named, the weak where it is ten times its bound or more, and nothing
else with it.
"""

import numpy as np
import pytest

from imubench.diagnosis.pipeline import diagnose
from imubench.format1 import read
from imubench.proof.bounds import visibility
from imubench.proof.case import build, make_case
from imubench.proof.filed import write
from imubench.trials.make import answers
from imubench.trials.match import deviation, holds, sure

pytestmark = pytest.mark.slow

SWING = {"base": "fixed", "swing": True}
SEEN = 10.0  # times the Cramer-Rao bound
SEEDS = {"end_stop": 201}  # the stop of 908 is never met
CASES = [
    *((name, "imu1", "hinge", {}) for name in ("gyro_bias", "accel_bias", "gyro_drift", "accel_drift", "gyro_scale")),
    *((name, "imu2", "hinge", {}) for name in ("accel_scale", "gyro_misalignment", "accel_misalignment")),
    ("g_sensitivity", "imu1", "hinge", {}),
    ("gyro_noise", "imu2", "hinge", {}),
    ("accel_noise", "imu1", "pendulum", {}),
    ("low_pass", "imu2", "hinge", {}),
    ("time_offset", "imu2", "hinge", {}),
    ("clock_skew", "imu2", "hinge", {}),
    ("saturation", "imu2", "hinge", {}),
    ("quantisation", "imu1", "pendulum", {}),
    ("dropouts", "imu2", "hinge", {}),
    ("vibration", "imu2", "hinge", {}),
    ("impacts", "imu1", "free", {}),
    ("mount_pose", "imu2", "hinge", SWING | {"encoder": True}),
    ("mount_shift", "imu2", "hinge", {}),
    ("soft_mount", "imu2", "hinge", {}),
    ("rocking_mount", "imu2", "hinge", {}),
    ("skin_sliding", "imu2", "hinge", {"encoder": True}),
    ("joint_play", "joint", "hinge", {}),
    ("axis_coupling", "joint", "hinge", {}),
    ("moving_centre", "joint", "hinge", {}),
    ("moving_pivot", "joint", "pendulum", {}),
    ("viscous_friction", "joint", "pendulum", {"swing": True}),
    ("dry_friction", "joint", "hinge", SWING),
    ("air_drag", "joint", "pendulum", {"swing": True}),
    ("joint_spring", "joint", "hinge", SWING),
    ("end_stop", "joint", "hinge", SWING),
    ("backlash", "joint", "hinge", {"base": "fixed", "encoder": True}),
    ("inertia", "body", "pendulum", {"swing": True}),
    ("gravity", "world", "hinge", {"base": "fixed"}),
]


@pytest.mark.parametrize(
    ("name", "at", "rig", "options"),
    [pytest.param(*c, id=c[0]) for c in CASES],
)
def test_one_effect(name, at, rig, options, tmp_path):
    seed = SEEDS.get(name, 900 + len(name))
    truth = make_case(tmp_path / "r", rig, [(name, at)], seed, seconds=25.0, **options)["effects"][0]
    said, _ = diagnose(read(tmp_path / "r")[0])
    assert [(f.effect, f.at) for f in said.findings] == [(name, at)]
    before, after = said.misfit
    assert after - 1 <= max(0.05 * (before - 1), 0.1)  # the noise level itself is known to some per cent
    for key, true in truth["parameters"].items():
        told = said.findings[0].parameters.get(key)
        if told is None or key in ("times", "channels", "mode", "band", "gyration"):
            continue
        off = deviation(name, key, told, np.asarray(true, dtype=float), 100.0)
        size = np.linalg.norm(np.asarray(true, dtype=float))
        assert np.all((np.abs(off) <= 3 * np.broadcast_to(told.std, np.shape(off))) | (np.abs(off) <= 0.1 * size)), key


OPEN = {
    (
        "vibration",
        "strong",
    ): "a hum of 1.3 m/s^2 that wanders: a mount on springs resounds with it, and the rest has no name",
}
SIZES = [
    pytest.param(
        *c,
        s,
        id=f"{c[0]}-{s}",
        marks=[pytest.mark.xfail(reason=OPEN[c[0], s], strict=True)] if (c[0], s) in OPEN else [],
    )
    for c in CASES
    for s in ("weak", "strong")
]


@pytest.mark.parametrize(("name", "at", "rig", "options", "strength"), SIZES)
def test_smaller_or_larger(name, at, rig, options, strength, tmp_path):
    case = build(rig, [(name, at)], SEEDS.get(name, 900 + len(name)), strength, seconds=25.0, **options)
    write(case, tmp_path / "r")
    right = answers(case.effects[0], case.options)
    found = sure(diagnose(read(tmp_path / "r")[0])[0].findings)
    assert [(f.effect, f.at) for f in found if not holds(right, f)] == []
    if strength == "strong" or (visibility(case) or 0.0) >= SEEN:
        assert len(found) == 1

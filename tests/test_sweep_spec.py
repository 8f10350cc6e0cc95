"""A sweep is a dataset's spec with axes: what they change, in which units, and what is refused in one line."""

from pathlib import Path

import numpy as np
import pytest

from imubench.dataset import make, parse_spec
from imubench.errors import InputError
from imubench.sweeps.axis import parse_axis, parse_parameter
from imubench.sweeps.spec import parse_sweep
from imubench.sweeps.units import ALIKE, factor, unit_of

BASE = """
name = "small"
seconds = 2
recordings = 3
limit_deg = 2
[[rig]]
family = "hinge"
mount_distance = [0.05, 0.1]
segment_length = 0.3
[[effect]]
name = "gyro_bias"
at = "imu2"
bias = 0
[[axis]]
parameter = "effect.gyro_bias.bias"
values = [0, 1, 2]
unit = "deg/s"
"""
SECOND = """
[[axis]]
parameter = "rig.mount_distance"
from = 5
to = 20
count = 2
unit = "cm"
"""


def sweep(text: str, **options):
    return parse_sweep({"sweep.toml": text.encode()}, **options)


def test_a_cell_is_the_spec_with_the_axes_numbers_in_it():
    found = sweep(BASE + SECOND)
    assert found.shape == (3, 2)
    cell = found.cell(2, 1)
    assert cell.effects[0].ranges["bias"].a == pytest.approx(2 * np.pi / 180, rel=1e-13)  # 14 digits are kept
    assert cell.rigs[0].ranges["mount_distance"].a == cell.rigs[0].ranges["mount_distance"].b == 0.2
    assert cell.recordings_per_rig == 1
    assert cell == parse_spec({"spec.toml": found.cell_toml(2, 1)})  # what `imubench generate` reads


def test_recordings_of_one_number_share_everything_but_the_axes():
    found = sweep(BASE)
    none, some = (make(found.cell(i), 5, 1).recording for i in (0, 2))
    other = make(found.cell(0), 5, 2).recording
    assert np.array_equal(none.imus[0].gyro, some.imus[0].gyro)
    assert np.array_equal(none.imus[1].accel, some.imus[1].accel)
    told = some.imus[1].gyro - none.imus[1].gyro
    assert np.abs(told - 2 * np.pi / 180).max() < 1e-14  # rounding of sums of 10 rad/s
    assert not np.array_equal(none.imus[0].gyro, other.imus[0].gyro)


def test_two_parameters_of_one_axis_and_tables_that_are_not_there_yet():
    text = BASE.replace('"effect.gyro_bias.bias"', '["rig.soft.frequency", "rig.rocking.frequency"]')
    cell = sweep(text.replace("[0, 1, 2]", "[6, 9]").replace('"deg/s"', '"Hz"')).cell(1)
    assert cell.rigs[0].soft.probability == cell.rigs[0].rocking.probability == 1.0
    assert cell.rigs[0].soft.ranges["frequency"].a == cell.rigs[0].rocking.ranges["frequency"].a == 9.0


def test_a_default_table_keeps_what_it_is():
    text = BASE.replace("effect.gyro_bias.bias", "motion.bandwidth").replace("[0, 1, 2]", "[1, 2]")
    cell = sweep(text.replace('"deg/s"', '"Hz"')).cell(1)
    assert cell.motions[0].kind == "random"
    assert cell.motions[0].ranges["bandwidth"].a == 2.0


def test_texts_are_values_too():
    text = BASE.replace("effect.gyro_bias.bias", "imu.profile").replace("[0, 1, 2]", '["perfect", "mpu9250"]')
    found = sweep(text.replace('unit = "deg/s"', ""))
    assert [found.cell(i).imus[0].profile.name for i in range(2)] == ["perfect", "mpu9250"]
    assert found.axes[0].is_text


def test_spaced_values_are_those_of_four_digits():
    axis = parse_axis({"parameter": "rig.soft.frequency", "from": 4, "to": 40, "count": 4, "scale": "log"}, "axis")
    assert axis.values == (4.0, 8.618, 18.57, 40.0)
    assert (axis.unit, axis.label) == ("Hz", "frequency of soft")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("effect.gyro_bias.bias", "effect.gyro_drift.rate", r"unknown unit in .*unit 'deg/s'; known: rad/s\^2"),
        ('unit = "deg/s"', 'unit = "mm"', r"unknown unit in sweep.toml: axis\[0\].unit 'mm'; known: rad/s, deg/s"),
        ("effect.gyro_bias.bias", "effect.gyro_scale.bias", r"expected an \[\[effect\]\] with name = 'gyro_scale'"),
        ("effect.gyro_bias.bias", "effect.gyro_bias.size", r"unknown key in .*effect\[0\] 'size'"),
        ("effect.gyro_bias.bias", "effect[1].gyro_bias.bias", r"expected \[\[effect\]\] number 1, got 1 of them"),
        ("effect.gyro_bias.bias", "rig", r"expected a path down to a number, got 'rig'"),
        ("effect.gyro_bias.bias", "rig..x", r"expected names between points"),
        ("[0, 1, 2]", "[2, 1]", r"expected numbers that rise"),
        ("[0, 1, 2]", "[1]", r"expected 2 to 200 values, got 1"),
        ("[0, 1, 2]", "[0, 1]\nscale = 'log'", r"expected values above 0 for scale = 'log'"),
        ("[0, 1, 2]", "[0, 1]\nfrom = 2", r"expected values or from, to and count, got both"),
        ("limit_deg = 2", "", r"expected limit_deg, for axes, or limit_mm, for joint centres.*got neither"),
        ("recordings = 3", "recordings = 0", r"recordings: expected a whole number from 1 to 10000, got 0"),
        ("seconds = 2", "seconds = 2\ntruth = 'core'", r"unknown key in sweep.toml 'truth'"),
        ("name = \"small\"", "quantile = 2", r"quantile: expected numbers >= 0 and <= 1, got 2"),
        ("segment_length = 0.3", "segment_length = 0.04", r"expected mounts that a segment of at most 0.04 m can hold"),
        ("[[axis]]", "[axis]", r"expected one or two \[\[axis\]\] tables"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_said_in_one_line(old, new, said):
    assert old in BASE
    with pytest.raises(InputError, match=said) as caught:
        sweep(BASE.replace(old, new))
    assert "\n" not in str(caught.value)


def test_a_cell_that_is_no_spec_is_named():
    text = BASE.replace("effect.gyro_bias.bias", "rig.soft.frequency").replace("[0, 1, 2]", "[10, 500]")
    with pytest.raises(InputError, match=r"rig.soft.frequency = 500 Hz: rig\[0\].soft.frequency: expected .*<= 200"):
        sweep(text.replace('unit = "deg/s"', ""))


def test_an_axis_twice_is_refused():
    with pytest.raises(InputError, match=r"axis: expected each parameter once"):
        sweep(BASE + SECOND.replace("rig.mount_distance", "effect.gyro_bias.bias").replace('"cm"', '"rad/s"'))


def test_files_beside_the_sweep_come_with_it(tmp_path):
    profiles = '[own]\nrate = { value = 50, unit = "Hz", source = "mine" }\n'
    text = BASE + "\n[[imu]]\nprofile = 'own'\nfile = 'own.toml'\n"
    (tmp_path / "own.toml").write_text(profiles)
    (tmp_path / "sweep.toml").write_text(text)
    found = sweep(text, path=Path(tmp_path / "sweep.toml"))
    assert found.content["own.toml"] == profiles.encode()
    assert found.cell(0).imus[0].profile.name == "own"


@pytest.mark.parametrize(
    ("path", "unit"),
    [
        ("rig.mount_distance", "m"),
        ("rig.soft.frequency", "Hz"),
        ("effect.skin_sliding.slide", "m/rad"),
        ("effect.soft_mount.damping_ratio", "1"),
        ("effect.gyro_noise.std", "rad/s"),
        ("effect.vibration.amplitude", "m/s^2"),
        ("effect.gyro_bias.bias.std", "rad/s"),
        ("effect.dropouts.probability", "1"),
        ("effect.saturation.limit", None),
        ("motion.rate", "rad/s"),
        ("rate", "Hz"),
    ],
)
def test_the_unit_of_a_parameter(path, unit):
    assert unit_of(parse_parameter(path, "here").keys) == unit


def test_every_unit_is_one_of_its_own_kind():
    assert all(factor(si, si, "here") == 1.0 for si in ALIKE)
    assert factor("mm/deg", "m/rad", "here") == pytest.approx(1e-3 * 180 / np.pi, rel=1e-15)  # the definition

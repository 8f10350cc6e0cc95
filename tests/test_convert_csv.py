"""The converter of plain tables: columns, units, rates, and what it refuses."""

import numpy as np
import pytest

from imubench.convert import CONVERTERS
from imubench.errors import InputError
from tests.chain import readings

NAMES = {"time": "t", "gyr_x": "wx", "gyr_y": "wy", "gyr_z": "wz", "acc_x": "ax", "acc_y": "ay", "acc_z": "az"}


def imu_csv(path, names=NAMES, time_scale=1.0, gyro_scale=1.0, accel_scale=1.0, timed=True):
    t = np.arange(200) / 50
    gyro, accel = readings(t, 0)
    rows = np.column_stack([t * time_scale, gyro * gyro_scale, accel * accel_scale])
    head = list(names.values())
    skip = 0 if timed else 1
    np.savetxt(path, rows[:, skip:], fmt="%.17g", delimiter=",", header=", ".join(head[skip:]), comments="")
    return t, gyro, accel


def test_csv_maps_columns_and_units(tmp_path):
    t, gyro, accel = imu_csv(tmp_path / "a.csv", time_scale=1e3, gyro_scale=180 / np.pi, accel_scale=1 / 9.80665)
    imu_csv(tmp_path / "b.csv", time_scale=1e3, gyro_scale=180 / np.pi, accel_scale=1 / 9.80665)
    columns = ",".join(f"{ours}={theirs}" for ours, theirs in NAMES.items())
    (out,) = CONVERTERS["csv"](
        tmp_path / "a.csv", second="b.csv", columns=columns, gyro_unit="deg/s", accel_unit="g", time_unit="ms"
    )
    assert (out.recording.name, out.recording.rig, len(out.recording.imus)) == ("a", "hinge", 2)
    imu = out.recording.imus[1]
    assert imu.name == "imu2" and imu.rate == pytest.approx(50)
    for got, expected in ((imu.time, t), (imu.gyro, gyro), (imu.accel, accel)):
        np.testing.assert_allclose(got, expected, rtol=1e-12, atol=1e-12)  # rounding of the unit factors


def test_csv_without_stamps_needs_a_rate(tmp_path):
    ours = {name: name for name in NAMES}
    t, gyro, _ = imu_csv(tmp_path / "a.csv", ours, timed=False)
    (out,) = CONVERTERS["csv"](tmp_path / "a.csv", rate="50", rig="pendulum")
    np.testing.assert_array_equal(out.recording.imus[0].time, t)
    np.testing.assert_array_equal(out.recording.imus[0].gyro, gyro)  # 17 digits bring a double back
    assert out.recording.rig == "pendulum" and out.recording.imus[0].rate == 50
    with pytest.raises(InputError, match=r"a.csv: expected column 'time' or the option rate, got gyr_x, gyr_y"):
        CONVERTERS["csv"](tmp_path / "a.csv")
    with pytest.raises(InputError, match=r"rate: expected a number > 0, got 0.0"):
        CONVERTERS["csv"](tmp_path / "a.csv", rate=0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"columns": "gyr_w=wx"}, "unknown column 'gyr_w'; known: time, gyr_x, gyr_y"),
        ({"columns": "gyr_x"}, "columns: expected pairs such as gyr_x=wx,acc_x=ax, got 'gyr_x'"),
        ({"columns": "time=stamp"}, "a.csv: expected column 'stamp' or the option rate, got t, wx"),
        ({"gyro_unit": "rpm"}, "unknown gyro_unit 'rpm'; known: rad/s, deg/s"),
        ({"accel_unit": "mg"}, r"unknown accel_unit 'mg'; known: m/s\^2, g"),
        ({"time_unit": "h"}, "unknown time_unit 'h'; known: s, ms, us, ns"),
        ({"rig": "pendulm"}, "unknown rig 'pendulm'; known: hinge, pendulum, free"),
        ({"rate": "fast"}, "rate: expected a number, got 'fast'"),
        ({"second": "c.csv"}, "c.csv: expected a file, got nothing of that name"),
    ],
)
def test_csv_wrong_option(tmp_path, options, message):
    imu_csv(tmp_path / "a.csv")
    with pytest.raises(InputError, match=message):
        CONVERTERS["csv"](tmp_path / "a.csv", **({"columns": NAMES} | options))


def test_csv_units_that_physics_rules_out(tmp_path):
    imu_csv(tmp_path / "a.csv", gyro_scale=180 / np.pi)
    with pytest.raises(InputError, match=r"a.csv, row \d+: expected under 100 rad/s, got .* gyro_unit 'rad/s'; known"):
        CONVERTERS["csv"](tmp_path / "a.csv", columns=NAMES)
    imu_csv(tmp_path / "b.csv", accel_scale=1 / 9.81)
    with pytest.raises(InputError, match=r"b.csv: expected about 9.81 m/s\^2 .* got 1 from accel_unit 'm/s\^2'; known"):
        CONVERTERS["csv"](tmp_path / "b.csv", columns=NAMES)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "a.csv: expected a header and rows of numbers, got an empty file"),
        ("{h}\n", "a.csv: expected rows of numbers below the header, got none"),
        ("{h}\n0,0,0,0,0,0,x\n", "a.csv, line 2, column 'acc_z': expected a number, got 'x'"),
        ("{h}\n0,0,0,0,0,0\n", "a.csv, line 2: expected 7 cells, as in the header, got 6"),
        ("{h}\n0,0,0,0,0,0,9.8\n0,0,0,0,0,0,9.8\n", "a.csv, time: .* a repeated stamp in row 1"),
        ("{h}\n1,0,0,0,0,0,9.8\n0,0,0,0,0,0,9.8\n", "a.csv, time: .* time running backwards in row 1"),
        ("{h},acc_z\n0,0,0,0,0,0,9.8,9.8\n", "a.csv: expected column 'acc_z' once, got it 2 times"),
    ],
)
def test_csv_broken_tables(tmp_path, text, message):
    (tmp_path / "a.csv").write_text(text.replace("{h}", ",".join(NAMES)))
    with pytest.raises(InputError, match=message):
        CONVERTERS["csv"](tmp_path / "a.csv")

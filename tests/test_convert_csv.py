"""The converter of plain tables: columns, units, rates, and what it refuses."""

import numpy as np
import pytest

from imubench.convert import CONVERTERS
from imubench.errors import InputError
from imubench.format1 import read_recording, write_recording
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


def test_csv_of_a_part_of_the_time(tmp_path):
    """Both sensors between the same two moments of one clock, which counts on as it did."""
    t, gyro, _ = imu_csv(tmp_path / "a.csv")
    rows = (tmp_path / "a.csv").read_text().splitlines()
    (tmp_path / "late.csv").write_text("\n".join([rows[0], *rows[26:]]) + "\n")  # begins half a second later
    columns = ",".join(f"{ours}={theirs}" for ours, theirs in NAMES.items())
    (out,) = CONVERTERS["csv"](tmp_path / "a.csv", second="late.csv", columns=columns, start="0.4", end="2")
    one, two = out.recording.imus
    inside = (t >= 0.4) & (t <= 2.0)
    np.testing.assert_array_equal(one.time, t[inside])
    np.testing.assert_array_equal(one.gyro, gyro[inside])
    assert (two.time[0], two.time[-1], two.rate) == (0.5, 2.0, 50.0)
    with pytest.raises(InputError, match=r"a\.csv: expected samples from 9 s to the end, got 0 to 3\.98 s"):
        CONVERTERS["csv"](tmp_path / "a.csv", columns=columns, start=9)


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


HEAD = "time,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z"
UNIX = 1_700_000_000  # s since 1970


def stamped(path, stamps):
    """Write a sensor at rest with these stamps, texts."""
    path.write_text("\n".join([HEAD, *(f"{t},0.01,0,0,0,0,9.81" for t in stamps)]) + "\n")
    return path


def counted(first, step, count=300):
    return [str(first + k * step) for k in range(count)]


@pytest.mark.parametrize(
    ("stamps", "unit", "message"),
    [
        (counted(0, 10), "", "got 0.1 from .* steps of 10 in seconds, as no time_unit is said: probably time_unit=ms"),
        (counted(0, 10_000), "", "probably time_unit=us"),
        (counted(0, 10_000_000), "", "probably time_unit=ns"),
        (counted(0, 1), "", "got 1 from median steps of 1 in seconds, .*: probably time_unit=ms"),  # 1 kHz
        (counted(0, 100_000), "ms", "got 0.01 from .* in time_unit 'ms': probably time_unit=us"),
        ([f"{k / 100}" for k in range(300)], "ms", "got 1e\\+05 from .* in time_unit 'ms': probably time_unit=s"),
        (counted(UNIX * 1000, 10), "", "up to 9e\\+09 s, got 1.7e\\+12 in .*: probably time_unit=ms, since 1970"),
        (counted(UNIX * 10**6, 10_000), "", "probably time_unit=us, since 1970"),
        (counted(UNIX * 10**9, 10_000_000), "", "probably time_unit=ns, since 1970"),
        (counted(UNIX * 1000, 10), "s", "probably time_unit=ms, since 1970"),
    ],
)  # fmt: skip
def test_csv_stamps_in_another_unit(tmp_path, stamps, unit, message):
    """Milliseconds since 1970 were written as a recording of 0.1 Hz, without a word."""
    options = {"time_unit": unit} if unit else {}
    with pytest.raises(InputError, match=f"a.csv, column 'time': .*{message}"):
        CONVERTERS["csv"](stamped(tmp_path / "a.csv", stamps), **options)


@pytest.mark.parametrize(
    ("stamps", "unit", "rate"),
    [
        ([f"{UNIX}.{k:02d}0000" for k in range(100)], "", 100.0),
        ([f"{UNIX}.{k:03d}25" for k in range(1000)], "s", 1000.0),
        (counted(UNIX * 1000, 10), "ms", 100.0),
        (counted(UNIX * 10**6 + 123, 1000), "us", 1000.0),
        (counted(UNIX * 10**9 + 123_456_789, 31_250), "ns", 32_000.0),  # float64 counts those in steps of 256
        ([f'"{UNIX * 10**9 + k * 31_250}"' for k in range(300)], "ns", 32_000.0),
    ],
)
def test_csv_stamps_since_1970_lose_no_digit(tmp_path, stamps, unit, rate):
    options = {"time_unit": unit} if unit else {}
    (out,) = CONVERTERS["csv"](stamped(tmp_path / "a.csv", stamps), **options)
    time = out.recording.imus[0].time
    assert out.recording.imus[0].rate == pytest.approx(rate, rel=1e-8)  # written with 9 digits
    assert 0 <= time[0] < 1
    np.testing.assert_allclose(np.diff(time), 1 / rate, rtol=0, atol=1e-15)  # rounding of times below 3 s
    assert f"The clock's zero was moved by {UNIX} s" in out.note


def test_csv_two_imus_keep_one_clock(tmp_path):
    stamped(tmp_path / "a.csv", counted(UNIX * 10**9 + 5_000_000, 10_000_000))
    stamped(tmp_path / "b.csv", counted(UNIX * 10**9 + 2_000_000_123, 10_000_000))
    (out,) = CONVERTERS["csv"](tmp_path / "a.csv", second="b.csv", time_unit="ns")
    one, two = out.recording.imus
    assert two.time[0] - one.time[0] == pytest.approx(1.995000123, abs=1e-12)  # rounding of seconds


def test_csv_stamps_of_a_clock_that_starts_with_the_recording_stay_as_they_are(tmp_path):
    (out,) = CONVERTERS["csv"](stamped(tmp_path / "a.csv", counted(3_600_000, 10)), time_unit="ms")
    assert out.recording.imus[0].time[0] == 3600.0
    assert "zero" not in out.note


def test_csv_of_a_slow_imu_needs_its_unit_said(tmp_path):
    """What looks like milliseconds may be seconds, if somebody says so; format 1 takes it from 0.2 Hz on."""
    (out,) = CONVERTERS["csv"](stamped(tmp_path / "a.csv", counted(0, 2)), time_unit="s")
    write_recording(out.recording, tmp_path / "r")
    assert read_recording(tmp_path / "r").imus[0].rate == 0.5


def test_csv_with_blank_lines_is_read_as_numbers(tmp_path):
    """The digits cannot be had line by line then: steps are right to what 64-bit numbers hold."""
    path = stamped(tmp_path / "a.csv", counted(UNIX * 10**9, 10_000_000))
    path.write_text(path.read_text().replace("\n", "\n\n", 2))
    (out,) = CONVERTERS["csv"](path, time_unit="ns")
    np.testing.assert_allclose(np.diff(out.recording.imus[0].time), 0.01, rtol=0, atol=6e-7)  # 256 and 238 ns

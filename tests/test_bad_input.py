"""Bad input ends with one line that says which file, which line or key, what was expected and what came."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from imubench import rotations
from imubench.convert import CONVERTERS
from imubench.errors import InputError
from imubench.format1 import read, read_recording, read_reference, write_recording
from imubench.format1.physics_checks import turning_ratio
from imubench.recording import Body, Encoder, Imu, Pose, Recording
from imubench.reference import Reference

Edit = Callable[[np.ndarray], np.ndarray]
N = 1200  # samples at 100 Hz
TIME = np.arange(N) / 100


def tilting(name: str = "imu1", **facts: object) -> Imu:
    """A sensor that rests for 2 s and then tilts to and fro about x: exact, about 20 deg/s."""
    angle = np.where(TIME > 2, 0.5 * (1 - np.cos(TIME - 2)), 0.0)
    rate = np.where(TIME > 2, 0.5 * np.sin(TIME - 2), 0.0)
    zero = np.zeros(N)
    accel = 9.81 * np.stack([zero, np.sin(angle), np.cos(angle)], axis=1)
    return Imu(name, TIME, np.stack([rate, zero, zero], axis=1), accel, rate=100.0, **facts)


@pytest.fixture
def good(tmp_path: Path) -> Path:
    """A recording with everything in it, which each test breaks in one place."""
    unit = np.tile([1.0, 0, 0, 0], (N, 1))
    recording = Recording(
        name="good",
        rig="hinge",
        imus=(tilting("imu1", gyro_range=35.0, accel_range=160.0), tilting("imu2")),
        encoders=(Encoder("hinge", TIME, 0.2 * np.sin(TIME)),),
        poses=(Pose("segment1", TIME, position=np.zeros((N, 3)), quaternion=unit),),
        free_swings=((1.0, 5.0),),
        body=Body(1.2, np.array([0, 0, -0.25]), np.array([0.03, 0.03, 0.002])),
    )
    reference = Reference(TIME, hinge_angle=0.2 * np.sin(TIME), quaternion1=unit)
    write_recording(recording, tmp_path / "rec", reference)
    read(tmp_path / "rec")
    return tmp_path / "rec"


def refused(folder: Path, *parts: str, by: Callable[[Path], object] = read) -> str:
    """Return the message of the one-line `InputError` that holds all `parts`."""
    with pytest.raises(InputError) as caught:
        by(folder)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    for part in parts:
        assert part in message
    return message


def swap(folder: Path, file: str, old: str, new: str) -> None:
    """Replace the one occurrence of a text in a file."""
    text = (folder / file).read_text()
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {file}"
    (folder / file).write_text(text.replace(old, new))


def set_line(folder: Path, file: str, line: int, new: str | None) -> None:
    """Replace one line of a file, counted from 1 as an editor does, or with None remove it."""
    lines = (folder / file).read_text().splitlines()
    lines[line - 1 : line] = [] if new is None else [new]
    (folder / file).write_text("\n".join(lines) + "\n")


def set_cell(folder: Path, file: str, line: int, column: str, new: str) -> None:
    lines = (folder / file).read_text().splitlines()
    cells = lines[line - 1].split(",")
    cells[lines[0].split(",").index(column)] = new
    set_line(folder, file, line, ",".join(cells))


def change(folder: Path, name: str, columns: str, edit: Edit) -> None:
    """Send the columns of one CSV that start with `columns` through `edit`."""
    path = folder / name
    header = path.read_text().splitlines()[0].split(",")
    values = np.genfromtxt(path, delimiter=",", skip_header=1)
    chosen = [k for k, column in enumerate(header) if column.startswith(columns)]
    values[:, chosen] = edit(values[:, chosen])
    np.savetxt(path, values, delimiter=",", header=",".join(header), comments="", fmt="%.17g")


# Files


def test_missing_folder(tmp_path):
    refused(tmp_path / "nowhere", "nowhere: expected a folder with recording.toml, got nothing of that name")
    refused(tmp_path / "nowhere", "expected a folder with recording.toml", by=read_reference)


def test_a_file_for_the_folder(good):
    refused(good / "imu1.csv", "imu1.csv: expected a folder with recording.toml, got a file")


def test_missing_recording_toml(good):
    (good / "recording.toml").unlink()
    refused(good, "rec: expected a folder with recording.toml, got one without")


@pytest.mark.parametrize("file", ["imu2.csv", "encoder.csv", "pose1.csv", "reference.csv"])
def test_missing_file(good, file):
    (good / file).unlink()
    refused(good, f"rec/{file}: expected a file, got nothing of that name")


@pytest.mark.parametrize("file", ["imu1.csv", "recording.toml"])
def test_a_folder_for_a_file(good, file):
    (good / file).unlink()
    (good / file).mkdir()
    refused(good, f"rec/{file}: expected a file, got a folder")


@pytest.mark.parametrize("file", ["recording.toml", "imu1.csv", "imu2.csv", "reference.csv"])
def test_a_file_that_vanishes_midway(good, file, monkeypatch):
    read_bytes = Path.read_bytes

    def vanishing(self: Path) -> bytes:
        if self.name == file:
            self.unlink(missing_ok=True)  # it was there when the folder was looked at
        return read_bytes(self)

    monkeypatch.setattr(Path, "read_bytes", vanishing)
    refused(good, f"rec/{file}: expected a file, got nothing of that name")


def test_a_file_that_breaks_while_it_is_read(good, monkeypatch):
    read_bytes = Path.read_bytes

    def failing(self: Path) -> bytes:
        if self.name == "imu1.csv":
            raise OSError(5, "Input/output error")
        return read_bytes(self)

    monkeypatch.setattr(Path, "read_bytes", failing)
    refused(good, "rec/imu1.csv: expected a readable file, got: Input/output error")


@pytest.mark.parametrize(
    "file", ["/etc/passwd.csv", "../imu1.csv", "a/../../b.csv", "C:\\\\imu1.csv", "..\\\\a.csv", ""]
)
def test_a_path_that_leads_out_of_the_folder(good, file):
    swap(good, "recording.toml", '"imu1.csv"', f'"{file}"')
    refused(good, "[[imu]] number 1, key 'file': expected a file below the recording's folder, got '")


def test_a_name_too_long_for_any_file(good):
    swap(good, "recording.toml", '"imu1.csv"', f'"{"x" * 5000}.csv"')
    refused(good, "expected a readable file, got: File name too long")


def test_a_file_of_another_kind(good):
    swap(good, "recording.toml", '"imu1.csv"', '"imu1.xlsx"')
    refused(good, "rec/imu1.xlsx: expected a .csv or .parquet file, got '.xlsx'")


def test_one_file_for_two_imus(good):
    swap(good, "recording.toml", '"imu2.csv"', '"imu1.csv"')
    refused(good, "[[imu]] number 2, key 'file': expected a file of its own, got imu1.csv of imu1")


# Tables


@pytest.mark.parametrize("content", [b"", b"\n\n", b"\xef\xbb\xbf"])
def test_empty_file(good, content):
    (good / "imu1.csv").write_bytes(content)
    refused(good, "rec/imu1.csv: expected a header and rows of numbers, got an empty file")


def test_header_only(good):
    (good / "imu1.csv").write_text("time,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z\n\n")
    refused(good, "rec/imu1.csv: expected rows of numbers below the header, got none")


def test_missing_column(good):
    swap(good, "imu1.csv", "acc_y", "accel_y")
    refused(good, "rec/imu1.csv: expected column 'acc_y', got columns time, gyr_x, gyr_y, gyr_z, acc_x, accel_y, acc_z")


def test_a_column_that_comes_twice(good):
    swap(good, "imu1.csv", "gyr_x,gyr_y,gyr_z,acc_x", "gyr_x,gyr_y,gyr_y,gyr_z")
    swap(good, "imu1.csv", "acc_y,acc_z", "acc_x,acc_y")
    refused(good, "expected column 'acc_z', got columns")
    swap(good, "imu1.csv", "gyr_y,gyr_y", "acc_z,gyr_y")
    read(good)
    swap(good, "encoder.csv", "time,angle", "time,angle,angle")
    refused(good, "rec/encoder.csv: expected column 'angle' once, got it 2 times")


def test_an_unknown_column_where_columns_are_optional(good):
    swap(good, "reference.csv", "hinge_angle", "hinge_angel")
    refused(good, "rec/reference.csv: unknown column 'hinge_angel'; known: time, hinge_angle, q1_w, q1_x")


def test_half_a_quaternion(good):
    swap(good, "reference.csv", "q1_z", "joint_x")
    refused(good, "rec/reference.csv: expected column 'q1_z' beside 'q1_w', got no such column")


@pytest.mark.parametrize("cell", ["nan", "NaN", "inf", "-Infinity", "1e400", ""])
def test_nan_or_infinity(good, cell):
    set_cell(good, "imu1.csv", 7, "gyr_y", cell)
    refused(good, "rec/imu1.csv, line 7, column 'gyr_y': expected a finite number, got ")


@pytest.mark.parametrize("file", ["pose1.csv", "reference.csv"])
def test_infinity_where_gaps_are_allowed(good, file):
    column = (good / file).read_text().split("\n")[0].split(",")[1]
    set_cell(good, file, 7, column, "inf")
    refused(good, f"rec/{file}, line 7, column '{column}': expected a finite number, got inf")


@pytest.mark.parametrize("cell", ["abc", "1,5", "1_000", "0x10", "12 V", "--", "1.2.3"])
def test_text_for_a_number(good, cell):
    set_cell(good, "imu1.csv", 9, "acc_z", f'"{cell}"')
    refused(good, f"rec/imu1.csv, line 9, column 'acc_z': expected a number, got '{cell}'")


def test_lines_are_counted_as_an_editor_does(good):
    path = good / "imu1.csv"
    lines = path.read_text().splitlines()
    path.write_bytes("\r\n".join(["", *lines[:3], "", "", *lines[3:]]).encode())  # line 4 of the table is line 7 now
    read(good)
    set_cell_line = path.read_text().splitlines()[6].split(",")
    path.write_bytes(path.read_bytes().replace(",".join(set_cell_line).encode(), b"0.02,x,0,0,0,0,9.81"))
    refused(good, "rec/imu1.csv, line 7, column 'gyr_x': expected a number, got 'x'")


@pytest.mark.parametrize(
    ("line", "count"), [("0.05,0,0,0,0,0", 6), ("0.05,0,0,0,0,0,9.81,1", 8), ("0.05;0;0;0;0;0;9.81", 1)]
)
def test_a_row_of_another_length(good, line, count):
    set_line(good, "imu1.csv", 7, line)
    refused(good, f"rec/imu1.csv, line 7: expected 7 cells, as in the header, got {count}")


def test_a_column_that_ends_early(good):
    for line in range(500, N + 2):
        set_cell(good, "imu1.csv", line, "acc_x", "")
    refused(good, "rec/imu1.csv, line 500, column 'acc_x': expected a finite number, got an empty cell")


def test_time_running_backwards(good):
    set_cell(good, "imu1.csv", 102, "time", "0.5")
    refused(
        good,
        "rec/imu1.csv, line 102, column 'time': expected increasing time, got time running backwards: "
        "0.5 s after 0.99 s",
    )


@pytest.mark.parametrize("file", ["imu1.csv", "encoder.csv", "pose1.csv", "reference.csv"])
def test_repeated_stamps(good, file):
    set_cell(good, file, 102, "time", "0.99")
    refused(good, f"rec/{file}, line 102, column 'time': expected increasing time, got a repeated stamp: 0.99 s after")


def test_repeated_samples_are_fine(good):
    change(good, "imu1.csv", "gyr", lambda gyro: np.repeat(gyro[::2], 2, axis=0))
    read(good)


def test_two_imus_that_do_not_overlap(good):
    change(good, "imu2.csv", "time", lambda time: time + 60)
    refused(good, "expected samples that overlap imu2 in time (60 to 71.99 s), got 0 to 11.99 s")
    for kind in ("encoder", "pose"):
        text = (good / "recording.toml").read_text()
        (good / "recording.toml").write_text(re.sub(rf"\[\[{kind}\]\][^\[]*", "", text))
    refused(
        good,
        "recording.toml: imu1 and imu2: expected recordings that overlap in time, got 0 to 11.99 s and 60 to 71.99 s",
    )


@pytest.mark.parametrize(
    ("file", "where"),
    [("encoder.csv", "[[encoder]] number 1"), ("pose1.csv", "[[pose]] number 1"), ("reference.csv", "[reference]")],
)
def test_another_record_that_does_not_overlap(good, file, where):
    change(good, file, "time", lambda time: time + 1.7e9)
    refused(
        good, f"{where}: expected samples that overlap imu1 in time (0 to 11.99 s), got 1700000000 to 1700000011.99 s"
    )


def test_a_free_swing_outside_the_recording(good):
    swap(good, "recording.toml", "start = 1.0\nend = 5.0", "start = 1000\nend = 5000")
    refused(good, "[[free_swing]] number 1: expected a window within 0 to 11.99 s, got 1000 to 5000 s")
    swap(good, "recording.toml", "start = 1000\nend = 5000", "start = 5\nend = 1")
    refused(good, "recording.toml: free_swing: expected end after start, got 5 s to 1 s")


@pytest.mark.parametrize("file", ["imu1.csv", "reference.csv"])
def test_non_utf8_in_a_table(good, file):
    content = (good / file).read_bytes().replace(b"\n0.05,", b"\n0.05\xb5,")
    (good / file).write_bytes(content)
    refused(good, f"rec/{file}, line 7: expected UTF-8 text, got byte 0xb5")


def test_utf16_in_a_table(good):
    (good / "imu1.csv").write_bytes((good / "imu1.csv").read_text().encode("utf-16"))
    refused(good, "rec/imu1.csv, line 1: expected UTF-8 text, got byte 0xff")


# Parquet


@pytest.fixture
def parquet(good: Path, tmp_path: Path) -> Path:
    recording, reference = read(good)
    write_recording(recording, tmp_path / "parquet", reference, "parquet")
    return tmp_path / "parquet"


@pytest.mark.parametrize("content", [b"", b"time,gyr_x\n0,1\n", b"PAR1 and nothing more PAR1"])
def test_unreadable_parquet(parquet, content):
    (parquet / "imu1.parquet").write_bytes(content)
    refused(parquet, "parquet/imu1.parquet: expected a ", "Parquet table, got")


def test_parquet_cut_short(parquet):
    path = parquet / "imu1.parquet"
    path.write_bytes(path.read_bytes()[:-200])
    refused(parquet, "parquet/imu1.parquet: expected a readable Parquet table, got: ")


def test_parquet_with_other_content(parquet):
    path = parquet / "imu1.parquet"
    table = pa.parquet.read_table(path)
    k = table.schema.get_field_index("acc_y")
    pa.parquet.write_table(table.drop_columns(["acc_y"]), path)
    refused(parquet, "imu1.parquet: expected column 'acc_y', got columns time, gyr_x")
    pa.parquet.write_table(table.set_column(k, "acc_y", pa.array(["1.0"] * N)), path)
    refused(parquet, "imu1.parquet, column 'acc_y': expected numbers, got string")
    pa.parquet.write_table(table.set_column(k, "acc_y", pa.array([None] * 5 + [1.0] * (N - 5), pa.float32())), path)
    refused(parquet, "imu1.parquet, row 1, column 'acc_y': expected a finite number, got an empty cell or NaN")
    pa.parquet.write_table(table.slice(0, 0), path)
    refused(parquet, "imu1.parquet: expected rows of numbers, got none")
    pa.parquet.write_table(table.set_column(0, "time", pa.array(np.r_[0.0, 0.0, TIME[2:]])), path)
    refused(parquet, "imu1.parquet, row 2, column 'time': expected increasing time, got a repeated stamp")


# recording.toml


def test_non_utf8_in_toml(good):
    content = (good / "recording.toml").read_bytes().replace(b'"good"', b'"G\xfcte"')
    (good / "recording.toml").write_bytes(content)
    refused(good, "recording.toml, line 2: expected UTF-8 text, got byte 0xfc")


@pytest.mark.parametrize("slip", ["rate 100", 'name = "imu1', "[[imu]", "x = " + "[" * 5000, "x = " + "9" * 5000])
def test_toml_syntax(good, slip):
    with (good / "recording.toml").open("a") as file:
        file.write(f"\n{slip}\n")
    refused(good, "rec/recording.toml: expected TOML, got: ")


def test_toml_syntax_names_the_line(good):
    swap(good, "recording.toml", 'rig = "hinge"', "rig = hinge")
    refused(good, "expected TOML, got: Invalid value (at line 3, column 7)")


@pytest.mark.parametrize(("version", "got"), [("2", "2"), ('"1"', "text '1'"), ("true", "true"), ("1.0", "1.0")])
def test_another_format(good, version, got):
    swap(good, "recording.toml", "format = 1", f"format = {version}")
    refused(good, f"recording.toml, key 'format': expected 1, got {got}")


@pytest.mark.parametrize(
    ("line", "where", "key"),
    [
        ('format = 1\n', "recording.toml, key 'format': expected an integer", "format"),
        ('rig = "hinge"\n', "recording.toml, key 'rig': expected a text", "rig"),
        ('file = "imu2.csv"\n', "[[imu]] number 2, key 'file': expected a text", "file"),
        ('joint = "hinge"\n', "[[encoder]] number 1, key 'joint': expected a text", "joint"),
        ("mass = 1.2\n", "[body], key 'mass': expected a number in kg", "mass"),
        ("end = 5.0\n", "[[free_swing]] number 1, key 'end': expected a number in s", "end"),
        ('file = "reference.csv"\n', "[reference], key 'file': expected a text", "file"),
    ],
)  # fmt: skip
def test_missing_key(good, line, where, key):
    swap(good, "recording.toml", line, "")
    refused(good, where, "got no such key")


@pytest.mark.parametrize(
    ("before", "added", "message"),
    [
        (
            "rig = ",
            "grav = 9.81",
            "recording.toml, unknown key 'grav'; known: format, name, rig, motion, gravity, base",
        ),
        ("rig = ", "[[gyro]]\n[x]\n", "unknown key 'gyro'; known: format, name"),
        ("mass = ", "unit = 'kg'", "[body], unknown key 'unit'; known: mass, com, inertia"),
        ('joint = "hinge"', "gyro_unit = 'deg/s'", "[[encoder]] number 1, unknown key 'gyro_unit'; known: joint, file"),
        (
            "gyro_range",
            "gyr_range = 1",
            "[[imu]] number 1, unknown key 'gyr_range'; known: name, file, rate, gyro_noise",
        ),
        ("segment = ", "joint = 'x'", "[[pose]] number 1, unknown key 'joint'; known: segment, file"),
        ("start = ", "stop = 1", "[[free_swing]] number 1, unknown key 'stop'; known: start, end"),
        ('file = "reference.csv"', "path = 'x'", "[reference], unknown key 'path'; known: file"),
    ],
)
def test_unknown_key(good, before, added, message):
    swap(good, "recording.toml", before, f"{added}\n{before}")
    if added.startswith("[["):  # keys below would belong to the new table: put it at the end instead
        swap(good, "recording.toml", f"{added}\n{before}", before)
        (good / "recording.toml").write_text((good / "recording.toml").read_text() + f"\n{added}")
    refused(good, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "good"', "name = 3", "recording.toml, key 'name': expected a text, got 3"),
        ('name = "good"', "name = 2026-01-01", "key 'name': expected a text, got a date or time 2026-01-01"),
        ("mass = 1.2", "mass = '1.2 kg'", "[body], key 'mass': expected a number in kg, got text '1.2 kg'"),
        ("mass = 1.2", "mass = true", "[body], key 'mass': expected a number in kg, got true"),
        ("gyro_range = 35.0", "gyro_range = [35]", "key 'gyro_range': expected a number in rad/s, got list [35]"),
        ("gyro_range = 35.0", "gyro_range = nan", "key 'gyro_range': expected a finite number, got nan"),
        ("gyro_range = 35.0", "gyro_range = -35", "imu1.gyro_range: expected a number > 0, got -35.0"),
        ("gyro_range = 35.0", "gyro_noise_std = -1", "key 'gyro_noise_std': expected a finite number >= 0, got -1"),
        ("gyro_range = 35.0", "mount_position = [0, 1]", "expected a list of 3 numbers in m, got list [0, 1]"),
        (
            "gyro_range = 35.0",
            "mount_position = [0, 1, '2']",
            "expected a list of 3 numbers in m, got list [0, 1, '2']",
        ),
        (
            "gyro_range = 35.0",
            "mount_position = 0.1",
            "key 'mount_position': expected a list of 3 numbers in m, got 0.1",
        ),
        ("gyro_range = 35.0", "mount_quaternion = [1, 0, 0]", "expected a list of 4 numbers in order w, x, y, z, got"),
        ("mass = 1.2", f"mass = {'9' * 400}", "[body], key 'mass': expected a finite number, got 999"),
        ("mass = 1.2", "mass = 0", "recording.toml: body.mass: expected a number > 0, got 0.0"),
        ("[body]", "[[body]]", "key 'body': expected one table [body], got list [{"),
        ("[[encoder]]", "[encoder]", "key 'encoder': expected tables [[encoder]], got a table"),
    ],
)
def test_wrong_type_or_value(good, old, new, message):
    swap(good, "recording.toml", old, new)
    refused(good, message)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('rig = "hinge"', 'rig = "pendulm"', "key 'rig': unknown rig 'pendulm'; known: hinge, pendulum, free"),
        ('rig = "hinge"', 'rig = "arm.xml"', "key 'rig': expected an MJCF file beside it, got no file 'arm.xml'"),
        ('rig = "hinge"', 'rig = "/a.xml"', "key 'rig': expected a file below the recording's folder, got '/a.xml'"),
        ('rig = "hinge"', 'rig = "hinge"\nmotion = "fast"', "unknown motion 'fast'; known: hand, free"),
        ('rig = "hinge"', 'rig = "hinge"\nbase = "loose"', "unknown base 'loose'; known: free, fixed"),
        ('rig = "hinge"', 'rig = "hinge"\ngravity = -9.81', "gravity: expected a number >= 0, got -9.81"),
        ('name = "imu2"', 'name = "imu3"', "unknown imu on rig hinge 'imu3'; known: imu1, imu2"),
        ('name = "imu2"', 'name = "imu1"', "expected each imu once, got imu1, imu1"),
        ('joint = "hinge"', 'joint = "knee"', "[[encoder]] number 1: unknown joint of rig hinge 'knee'; known: hinge"),
        ('"segment1"', '"thigh"', "[[pose]] number 1: unknown segment of rig hinge 'thigh'; known: segment1, segment2"),
    ],
)
def test_unknown_name(good, old, new, message):
    swap(good, "recording.toml", old, new)
    refused(good, "rec/recording.toml", message)


def test_quaternions_that_are_no_units(good):
    swap(good, "recording.toml", "gyro_range = 35.0", "mount_quaternion = [1, 0, 0.2, 0]")
    message = "imu1.mount_quaternion: expected a unit quaternion w, x, y, z, got [1.0, 0.0, 0.2, 0.0] of norm 1.02"
    refused(good, f"rec/recording.toml: {message}")
    swap(good, "recording.toml", "mount_quaternion = [1, 0, 0.2, 0]", "")
    swap(good, "recording.toml", 'rig = "hinge"', 'rig = "hinge"\nbase_quaternion = [0, 0, 0, 0]')
    refused(good, "base_quaternion: expected a unit quaternion")


@pytest.mark.parametrize(("file", "first"), [("reference.csv", "q1_w"), ("pose1.csv", "qw")])
def test_a_measured_quaternion_that_is_no_unit(good, file, first):
    set_cell(good, file, 20, first, "0.98")
    refused(good, f"rec/{file}, line 20, columns {first} to ", "got [0.98, 0.0, 0.0, 0.0] of norm 0.98")
    set_cell(good, file, 20, first, "0.995")  # three digits are enough
    read(good)
    set_cell(good, file, 20, first, "")
    read(good)


def test_nothing_measured(good):
    text = (good / "recording.toml").read_text().split("[[")[0]
    (good / "recording.toml").write_text(text)
    refused(good, "recording.toml: good: expected at least one imu, encoder or pose, got none")


# Units


def test_degrees_beyond_the_declared_range(good):
    change(good, "imu1.csv", "gyr", lambda gyro: gyro * 4 * 180 / np.pi)
    refused(
        good,
        "rec/imu1.csv, line ",
        "column 'gyr_x': expected at most 1.5 times the declared range of 35 rad/s, got 52.",
        "probably deg/s",
    )


def test_degrees_beyond_any_gyroscope(good):
    change(good, "imu2.csv", "gyr", lambda gyro: gyro * 4 * 180 / np.pi)
    refused(good, "imu2.csv, line ", "expected |gyr| under 70 rad/s, the limit of such sensors", "probably deg/s")


def test_counts_beyond_any_gyroscope(good):
    change(good, "imu2.csv", "gyr", lambda gyro: gyro * 16.4 * 10 * 180 / np.pi)
    refused(good, "expected |gyr| under 70 rad/s", "probably raw counts")


def test_slow_motion_in_degrees_is_told_by_gravity(good):
    change(good, "imu2.csv", "gyr", lambda gyro: gyro * 180 / np.pi)  # 29 deg/s: no gyroscope's limit says it
    refused(good, "rec/imu2.csv, line 2: expected gyr in rad/s, got rates 57", "as fast as gravity turns in acc")


@pytest.mark.parametrize(
    ("unit", "factor"), [("g", 1 / 9.80665), ("mg", 1e3 / 9.80665), ("raw counts", 2048 / 9.80665)]
)
def test_specific_force_at_rest_far_from_g(good, unit, factor):
    change(good, "imu2.csv", "acc", lambda accel: accel * factor)
    refused(good, "rec/imu2.csv, line 2: expected |acc| of about 9.81 m/s^2 at rest, got ", f"probably {unit}")


def test_specific_force_beyond_the_declared_range(good):
    change(good, "imu1.csv", "acc", lambda accel: accel * 1e3 / 9.80665)
    refused(good, "imu1.csv, line 2, column 'acc_z': expected at most 1.5 times the declared range of 160 m/s^2", "mg")


@pytest.mark.parametrize(
    ("unit", "factor"), [("g", 1 / 9.80665), ("mg", 1e3 / 9.80665), ("raw counts", 2048 / 9.80665)]
)
def test_specific_force_of_another_unit_without_rest(good, unit, factor):
    shaken = 9.81 * np.tile([0, 0, 1], (N, 1)) + 5 * np.sin(TIME[:, None] * [20, 30, 40])
    change(good, "imu2.csv", "acc", lambda _: shaken)
    read(good)
    change(good, "imu2.csv", "acc", lambda _: shaken * factor)
    refused(good, "imu2.csv, line 2: expected |acc| in m/s^2, got a me", f"probably {unit}")


def test_specific_force_without_gravity(good):
    change(good, "imu2.csv", "acc", lambda accel: accel - accel)
    refused(good, "at rest, got 0: probably gravity was taken out")


@pytest.mark.parametrize(("unit", "factor"), [("milliseconds", 1e3), ("microseconds", 1e6), ("nanoseconds", 1e9)])
def test_time_in_another_unit(good, unit, factor):
    change(good, "imu1.csv", "time", lambda time: time * factor)
    refused(
        good,
        f"imu1.csv, line 3, column 'time': expected steps of about 0.01 s by the declared rate of 100 Hz, "
        f"got {0.01 * factor:g} s (median): probably {unit}",
    )


@pytest.mark.parametrize(
    ("new", "message"),
    [
        ("gyro_range = 2000", "key 'gyro_range': expected rad/s, under 100, got 2000: probably deg/s"),
        ("accel_range = 8", "key 'accel_range': expected m/s^2, from gravity (9.81) to 5000, got 8: probably g"),
        ("accel_range = 16000", "from gravity (9.81) to 5000, got 16000: probably mg or counts"),
        (
            "mount_position = [-100, 0, 20]",
            "key 'mount_position': expected a vector in m, under 10 m long",
        ),
    ],
)
def test_declared_facts_in_another_unit(good, new, message):
    text = (good / "recording.toml").read_text()
    text = text.replace("gyro_range = 35.0\n", "").replace("accel_range = 160.0\n", f"{new}\n")
    (good / "recording.toml").write_text(text)
    refused(good, "recording.toml, [[imu]] number 1", message)


def test_a_body_in_millimetres(good):
    swap(good, "recording.toml", "-0.25", "-250.0")
    refused(good, "recording.toml, [body], key 'com': expected a vector in m, under 10 m long", "probably mm")


@pytest.mark.parametrize(("file", "column"), [("encoder.csv", "angle"), ("reference.csv", "hinge_angle")])
def test_a_joint_angle_in_degrees(good, file, column):
    change(good, file, column, lambda angle: 90 * np.sin(2 * np.arange(N)[:, None] / 100))
    refused(good, f"rec/{file}, line ", f"column '{column}': expected rad, got ", "rad/s: probably degrees")


def test_a_position_in_millimetres(good):
    change(good, "pose1.csv", "y", lambda _: 300 * np.sin(TIME[:, None]))
    refused(good, "rec/pose1.csv, line 2, position: expected m, got ", "probably millimetres")


# What must not be refused


def accepted(good: Path, gyro: np.ndarray, accel: np.ndarray, reaches: float) -> Imu:
    """Read the samples as imu2, with nothing declared, after a look that they are as harsh as their test says."""
    assert np.abs(gyro).max() > reaches
    change(good, "imu2.csv", "gyr", lambda _: gyro)
    change(good, "imu2.csv", "acc", lambda _: accel)
    return read_recording(good).imus[1]


def test_saturated_and_noisy_samples_are_data(good):
    change(good, "imu1.csv", "gyr", lambda gyro: np.clip(gyro * 200, -35, 35) * 1.2)
    assert np.abs(read_recording(good).imus[0].gyro).max() == pytest.approx(42)


def test_lost_samples_and_jitter_are_data(good):
    path = good / "imu1.csv"
    rng = np.random.default_rng(1)
    header, *lines = path.read_text().splitlines()
    kept = [line for line, keep in zip(lines, rng.random(N) > 0.5, strict=True) if keep]
    path.write_text("\n".join([header, *kept]) + "\n")
    change(good, "imu1.csv", "time", lambda time: time + rng.uniform(0, 0.009, time.shape))
    read(good)


def test_fast_motion_without_rest_is_data(good):
    rate = 33 * np.sin(TIME[:, None] * [7.0, 9.0, 11.0])
    accel = 9.81 * np.tile([0, 0, 1], (N, 1)) + 0.2 * rate**2 + 30 * np.cos(TIME[:, None] * [17, 19, 23])
    accepted(good, rate, accel, reaches=30)


@pytest.mark.parametrize("lever", [0.0, 0.5, 0.9, 0.98256, 1.0, 1.2])
@pytest.mark.parametrize("amplitude", [0.05, 0.25, 1.2])
def test_a_swinging_pendulum_is_data(good, lever, amplitude):
    """At the centre of oscillation (lever 1) specific force stays along the rod, whatever the rod does."""
    length = 0.5  # m
    angle = amplitude * np.cos(np.sqrt(9.81 / length) * TIME)
    rate = np.gradient(angle, TIME)
    r = lever * length
    along = 9.81 * np.cos(angle) + r * rate**2
    across = 9.81 * np.sin(angle) * (1 - lever)
    zero = np.zeros(N)
    gyro = np.stack([zero, rate, zero], axis=1)
    accepted(good, gyro, np.stack([across, zero, along], axis=1), reaches=amplitude)


@pytest.mark.parametrize("radius", [0.02, 0.2, 1.0])
def test_a_turntable_is_data(good, radius):
    """Spun up and down about the vertical: no rest, and gravity never turns in sensor axes."""
    rate = 3 + 2 * np.sin(TIME)
    zero = np.zeros(N)
    tilt = rotations.from_axis_angle(np.array([1.0, 0, 0]), 0.3)
    gyro = rotations.rotate_back(tilt, np.stack([zero, zero, rate], axis=1))
    accel = rotations.rotate_back(tilt, np.stack([-radius * rate**2, radius * 2 * np.cos(TIME), 9.81 + zero], axis=1))
    accepted(good, gyro, accel, reaches=4)


def test_a_short_fall_and_knocks_are_data(good):
    accel = 9.81 * np.tile([0.0, 0, 1], (N, 1))
    accel[300:370] = 0.0  # 0.7 s, 2.4 m
    accel[100::100] = 800.0
    gyro = np.full((N, 3), 0.02)
    gyro[50] = 200.0  # one bad sample is no unit
    accepted(good, gyro, accel, reaches=100)


def test_biased_sensors_at_rest_are_data(good):
    rng = np.random.default_rng(0)
    gyro = rng.normal([0.1, -0.2, 0.15], 0.02, size=(N, 3))  # 15 deg/s of bias
    accel = rng.normal([0.5, 0.5, 9.0], 0.2, size=(N, 3))
    accepted(good, gyro, accel, reaches=0.2)


def test_no_gravity_where_none_is_declared(good):
    swap(good, "recording.toml", 'rig = "hinge"', 'rig = "hinge"\ngravity = 0')
    for file in ("imu1.csv", "imu2.csv"):
        change(good, file, "acc", lambda accel: accel - accel)
    read(good)


def test_the_angle_of_a_joint_that_turns_many_times_is_data(good):
    change(good, "encoder.csv", "angle", lambda _: (30 * TIME[:, None] + np.pi) % (2 * np.pi) - np.pi)
    read(good)
    change(good, "encoder.csv", "angle", lambda _: 30 * TIME[:, None])
    read(good)


def test_gravity_turns_as_fast_as_the_gyroscope_says():
    rate, zero = 3.0, np.zeros(N)
    accel = 9.81 * np.stack([zero, np.sin(rate * TIME), np.cos(rate * TIME)], axis=1)
    imu = Imu("imu1", TIME, np.stack([rate + zero, zero, zero], axis=1), accel, rate=100.0)
    slope, correlation, count = turning_ratio(imu, 9.81)
    assert slope == pytest.approx(1, rel=0.02)  # means over 0.1 s: second order in 3 rad/s x 0.1 s
    assert correlation > 0.999  # nothing but the same second order
    assert count == 23  # 119 steps between means over 0.1 s: 23 times five


@pytest.mark.parametrize("imu", ["rigid", "nonrigid"])
def test_real_recordings_pass_and_in_other_units_do_not(tmp_path, recordings, imu):
    (converted,) = CONVERTERS["diodem"](recordings / "diodem" / "trial1", segments="3-4", imu=imu)
    folder = tmp_path / "rec"
    write_recording(converted.recording, folder, converted.reference)
    read(folder)
    original = (folder / "imu2.csv").read_text()
    units = {
        "deg/s": ("gyr", 180 / np.pi), "g": ("acc", 1 / 9.81), "mg": ("acc", 1e3 / 9.81), "milliseconds": ("time", 1e3),
    }  # fmt: skip
    for unit, (columns, factor) in units.items():
        change(folder, "imu2.csv", columns, lambda values, factor=factor: values * factor)
        refused(folder, "rec/imu2.csv, line ", f"probably {unit}")
        (folder / "imu2.csv").write_text(original)


def test_a_damaged_recording_never_ends_in_another_error(good):
    """Any byte may be broken: it is read, or refused by an `InputError` of one line."""
    rng = np.random.default_rng(0)
    files = {name: (good / name).read_bytes() for name in ("recording.toml", "imu1.csv", "pose1.csv", "reference.csv")}
    for name, content in files.items():
        for _ in range(100):
            broken = bytearray(content)
            for place in rng.integers(0, min(len(broken), 2000), size=rng.integers(1, 4)):
                broken[place] = rng.integers(0, 256)
            (good / name).write_bytes(bytes(broken))
            try:
                read(good)
            except InputError as error:
                assert str(error).strip()
        (good / name).write_bytes(content)

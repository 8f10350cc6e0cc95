"""A broken file or table ends with one line: which file, line and column, what was expected and what came."""

import os
import re
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest

from imubench.errors import InputError
from imubench.format1 import read, read_reference, write_recording
from tests.damage import TIME, N, change, refused, set_cell, set_line, swap

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
    opened = os.open

    def vanishing(path: Path, *flags: int) -> int:
        if Path(path).name == file:
            Path(path).unlink(missing_ok=True)  # it was there when the folder was looked at
        return opened(path, *flags)

    monkeypatch.setattr(os, "open", vanishing)
    refused(good, f"rec/{file}: expected a file, got nothing of that name")


def test_a_file_that_breaks_while_it_is_read(good, monkeypatch):
    opened = os.open

    def failing(path: Path, *flags: int) -> int:
        if Path(path).name == "imu1.csv":
            raise OSError(5, "Input/output error")
        return opened(path, *flags)

    monkeypatch.setattr(os, "open", failing)
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


# Anything


@pytest.mark.long
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

"""The one way in: regular files only, bounded before anything is allocated, everything wrong in one line."""

import io
import os
import resource
import struct
import zlib
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
from scipy.io import savemat

from imubench.errors import LONGEST_MESSAGE, InputError, printable, shortened, shown
from imubench.inputs.files import below, inside, plain_name, read_bytes, what_is
from imubench.inputs.hdf5 import read_hdf5
from imubench.inputs.json import parse_json
from imubench.inputs.limits import NUMBERS
from imubench.inputs.mat import read_mat
from imubench.inputs.mjcf import checked_mjcf, compiled
from imubench.inputs.tables import read_table
from imubench.inputs.toml import parse_toml
from imubench.models import RIG_FILES, mjcf
from tests.damage import refused

COLUMNS = ["time", "gyr_x", "gyr_y", "gyr_z", "acc_x", "acc_y", "acc_z"]


def says(match: str, call, *words: object) -> str:
    """Return the one line with which a call refuses its input."""
    with pytest.raises(InputError, match=match) as caught:
        call(*words)
    message = str(caught.value)
    assert len(message) <= LONGEST_MESSAGE and message.isprintable()
    return message


# Messages


def test_a_message_is_one_printable_line_of_300_characters():
    message = str(InputError("a\nb\x1b[31m" + "x" * 5000 + " end"))
    assert message.startswith("a b\\x1b[31mxxx") and message.endswith("xxx end")
    assert len(message) == LONGEST_MESSAGE and message.isprintable()
    assert printable("\ud800\x00") == "\\ud800\\x00"
    assert shortened("x" * 10, 10) == "x" * 10


def test_values_of_any_size_are_shown():
    deep: list = []
    for _ in range(5000):
        deep = [deep]
    assert shown(deep) == "a list too large to be shown"
    assert shown(10**5000) == "a int too large to be shown"
    assert len(shown("y" * 10_000)) == 60


# Files


def test_a_pipe_a_device_and_a_folder_are_no_files(good, tmp_path):
    (good / "imu1.csv").unlink()
    os.mkfifo(good / "imu1.csv")
    refused(good, "rec/imu1.csv: expected a file, got a pipe")  # without waiting for somebody to write into it
    (good / "imu1.csv").unlink()
    (good / "imu1.csv").symlink_to("/dev/zero")
    refused(good, "rec/imu1.csv: expected a file, got a device")
    assert (what_is(good), what_is(tmp_path / "none")) == ("a folder", "nothing of that name")


def test_a_file_of_many_gigabytes_is_not_read(good):
    for name, most in (("imu1.csv", "1,024 MB"), ("recording.toml", "4 MB")):
        with (good / name).open("ab") as file:
            file.truncate(10 * 2**30)  # sparse: it takes no place on the disk
        refused(good, f"rec/{name}: expected a file of at most {most}, got 10,240 MB")
        (good / name).write_bytes(b"")


def test_a_file_may_not_grow_beyond_the_limit_while_it_is_read(tmp_path):
    (tmp_path / "a").write_bytes(b"12345")
    assert read_bytes(tmp_path / "a", 5) == b"12345"
    says("expected a file of at most 4 bytes, got 5 bytes", read_bytes, tmp_path / "a", 4)


LEADING_ELSEWHERE = ["../a", "/etc/passwd", "a/../../b", "C:\\a", "..\\a", "", "a\0b", "a\x1b[31m", 3, ["a"], None]


@pytest.mark.parametrize("name", LEADING_ELSEWHERE)
def test_a_name_stays_below_its_folder(name, tmp_path):
    says("here: expected a file below its folder, got", below, tmp_path, name, "here")
    assert below(tmp_path, "a/b.csv", "here") == tmp_path / "a" / "b.csv"


def test_a_link_out_of_the_folder_is_not_inside(tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "link").symlink_to(tmp_path)
    says("which leads elsewhere", inside, tmp_path / "in", "link/x", "here")
    assert inside(tmp_path / "in", "a", "here") == tmp_path / "in" / "a"


@pytest.mark.parametrize("name", ["", " a", ".hidden", "..", "a/b", "a\\b", "a:b", "a\nb", "x" * 300, 7])
def test_a_plain_name_is_that_of_one_file(name):
    says("here: expected a name", plain_name, name, "here")
    assert plain_name("rig-3 [fast]", "here") == "rig-3 [fast]"


# TOML and JSON


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"x = " + b"[" * 3000 + b"]" * 3000, "at most 32 deep"),
        (b".".join([b"x"] * 3000) + b" = 1", "at most 32 deep"),
        (b"x = " + b"9" * 5000, "expected TOML, got: Exceeds the limit"),
        (b"x = " + b"9" * 300, "key 'x': expected a whole number of 64 bits, got one of 997 bits"),
        (b"x = 1e400", "key 'x': expected a finite number, got inf"),
        (b"[[a]]\n[[a]]\ny = nan", r"key 'a\[1\].y': expected a finite number, got nan"),
        (b'x = "a\\u001b[31m"', r"key 'x': expected text without control characters, got 'a\\x1b\[31m'"),
        (b'"a\\u0000" = 1', "expected text without control characters"),
        (b"x = \xff", "f.toml, line 1: expected UTF-8 text, got byte 0xff"),
        (b"x", "expected TOML, got: "),
    ],
)
def test_toml_is_bounded(content, message):
    says(message, parse_toml, content, "f.toml")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"[" * 100_000, "at most 32 deep"),
        (b"[" * 40 + b"]" * 40, "at most 32 deep"),
        (b'{"x": ' + b"9" * 5000 + b"}", "expected JSON, got: Exceeds the limit"),
        (b'{"x": -1e999}', "key 'x': expected a finite number, got -inf"),
        (b'{"x": NaN}', "the number NaN, which is not finite"),
        (b"[" + b"0," * 1_000_000 + b"0]", "at most 1,000,000 values, got more"),
        (b"\xfe", "expected UTF-8 text"),
        (b"{", "expected JSON, got: "),
    ],
)
def test_json_is_bounded(content, message):
    says(message, parse_json, content, "f.json")


# Tables


def test_a_header_beyond_the_csv_modules_limit_is_one_line(good):
    (good / "imu1.csv").write_text(",".join(["time", "x" * 140_000]) + "\n0,1\n")
    refused(good, "rec/imu1.csv, line 1: expected a line of at most 100,000 bytes, got a longer one")
    (good / "imu1.csv").write_text(",".join(f"c{k}" for k in range(5000)) + "\n")
    refused(good, "rec/imu1.csv: expected at most 4,096 columns, got 5,000")


def test_a_line_without_end_is_not_read(good):
    text = (good / "imu1.csv").read_text()
    (good / "imu1.csv").write_text(text + "1" * 5_000_000)
    refused(good, f"line {text.count(chr(10)) + 1}: expected a line of at most 100,000 bytes, got a longer one")


def test_the_line_of_an_error_is_found_behind_many_blocks(good):
    """The last of 300,000 lines is wrong; only its block is looked at cell by cell."""
    rows = "".join(f"{k / 100},0,0,0,0,0,9.81\n" for k in range(300_000))
    for last, message in (
        ("3000,0,0,x,0,0,0", "line 300002, column 'gyr_z': expected a number, got 'x'"),
        ("3000,0,0", "line 300002: expected 7 cells, as in the header, got 3"),
        ("3000,0,0,,0,0,0", "line 300002, column 'gyr_z': expected a finite number, got an empty cell or NaN"),
        ("1,0,0,0,0,0,0", "line 300002, column 'time': expected increasing time, got time running backwards"),
    ):
        (good / "imu1.csv").write_text(",".join(COLUMNS) + "\n" + rows + last + "\n")
        refused(good, message)


def test_lines_of_every_kind_of_end_are_counted(tmp_path):
    for end in ("\n", "\r\n", "\r"):
        path = tmp_path / "t.csv"
        path.write_bytes(end.join(["", "\ufefftime,x" if not end else "time,x", "0,1", "", "1,2", "1,3", ""]).encode())
        says("line 6, column 'time': expected increasing time", read_table, path, ["time", "x"])


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("last", ["", "1", "3"])
def test_lines_of_every_kind_of_end_are_read(end, last, tmp_path):
    """Ends of an old system, and blank lines at the end of a file, which may be a block of their own."""
    (tmp_path / "t.csv").write_bytes((end.join(["time,a", "0,1", "1,2"]) + end * int(last or 0)).encode())
    table = read_table(tmp_path / "t.csv", ["time", "a"])
    assert table.columns["a"].tolist() == [1.0, 2.0]


def test_a_parquet_file_that_unpacks_to_gigabytes_is_not_read(good):
    (good / "imu1.csv").unlink()
    rows = NUMBERS // len(COLUMNS) + 1
    zeros = pa.table(dict.fromkeys(COLUMNS, np.zeros(rows)))
    pa.parquet.write_table(zeros, good / "imu1.parquet", compression="zstd")
    assert (good / "imu1.parquet").stat().st_size < 2**20
    refused(good, f"rec/imu1.parquet: expected at most {rows - 1:,} rows of 7 columns, got {rows:,} or more")


@pytest.mark.parametrize(
    "kind", [pa.list_(pa.float64(), 5000), pa.binary(5000), pa.struct([("a", pa.list_(pa.list_(pa.int8(), 100), 50))])]
)
def test_a_parquet_column_whose_every_row_is_wide_is_refused_before_it_is_read(kind, tmp_path):
    """Two nulls of a list of fixed size whose damaged type says 34 million took 1 GB."""
    pa.parquet.write_table(pa.table({"wide": pa.nulls(2, kind)}), tmp_path / "t.parquet")
    says("column 'wide': expected at most 4,096 values a row, got 5,000", read_table, tmp_path / "t.parquet", ["wide"])


def test_a_parquet_column_that_is_there_twice_is_refused(tmp_path):
    pa.parquet.write_table(pa.Table.from_arrays([pa.array([1.0]), pa.array([2.0])], ["a", "a"]), tmp_path / "t.parquet")
    says("expected each column once, got 'a' more often", read_table, tmp_path / "t.parquet", ["a"])


def test_a_parquet_column_of_something_else_is_refused(tmp_path):
    pa.parquet.write_table(pa.table({"time": ["a"]}), tmp_path / "t.parquet")
    says("column 'time': expected numbers, got string", read_table, tmp_path / "t.parquet", ["time"])
    (tmp_path / "t.parquet").write_bytes(b"PAR1 but nothing else PAR1")
    says("expected a readable Parquet table, got: ", read_table, tmp_path / "t.parquet", ["time"])


# HDF5 and MATLAB


def test_hdf5_is_read_without_following_links(tmp_path):
    path = tmp_path / "t.hdf5"
    with h5py.File(tmp_path / "other.hdf5", "w") as other:
        other["x"] = np.zeros(3)
    with h5py.File(path, "w") as file:
        file["good"] = np.arange(3.0)
        file["outside"] = h5py.ExternalLink("other.hdf5", "x")
        file["words"] = "text"
        file.create_dataset("large", shape=(NUMBERS + 1,), dtype="f8", chunks=(1000,))  # takes no place
        file.create_dataset("elsewhere", shape=(4,), dtype="f8", external=[("/etc/passwd", 0, 32)])
        file.attrs["rate"] = "fast"
    assert read_hdf5(path, ["good"]).arrays["good"].tolist() == [0, 1, 2]
    says("key 'outside': expected the numbers themselves, got a link", read_hdf5, path, ["outside"])
    says("key 'elsewhere': expected the numbers themselves, got those of another", read_hdf5, path, ["elsewhere"])
    says("key 'words': expected numbers, got ", read_hdf5, path, ["words"])
    says("key 'large': expected at most 40,000,000 numbers", read_hdf5, path, ["large"])
    says("expected key 'none', got elsewhere, good", read_hdf5, path, ["none"])
    says("attribute 'rate': expected a number, got 'fast'", read_hdf5, path, ["good"], (), ["rate"])
    path.write_bytes(path.read_bytes()[:600])
    says("expected a readable HDF5 file, got: ", read_hdf5, path, ["good"])


@pytest.mark.long
def test_a_matlab_file_that_unpacks_to_gigabytes_is_not_read(tmp_path):
    path = tmp_path / "t.mat"
    savemat(path, {"x": np.arange(4.0)}, do_compression=True)
    assert read_mat(path, ["x"])["x"].ravel().tolist() == [0, 1, 2, 3]
    says("expected variable 'y', got x", read_mat, path, ["y"])
    press = zlib.compressobj(9)
    body = b"".join([*(press.compress(bytes(2**20)) for _ in range(400)), press.flush()])
    head = path.read_bytes()[:128]
    path.write_bytes(head + (15).to_bytes(4, "little") + len(body).to_bytes(4, "little") + body)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    says("expected at most 305 MB when unpacked, got more", read_mat, path, ["x"])
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000  # kB: unpacked a megabyte at a time


@pytest.mark.parametrize("kind", [0, 8, 19, 4000])
def test_matlab_data_of_no_known_kind_is_refused_before_scipy_sees_it(kind, tmp_path):
    """SciPy looks such a number up in a table and ends the interpreter."""
    savemat(tmp_path / "a.mat", {"x": np.arange(100.0) + 0.1})
    content = (tmp_path / "a.mat").read_bytes()
    tag = struct.pack("<II", 9, 800)  # miDOUBLE
    assert content.count(tag) == 1
    (tmp_path / "a.mat").write_bytes(content.replace(tag, struct.pack("<II", kind, 800)))
    says(f"expected data of a kind that MATLAB 5 knows, got {kind}", read_mat, tmp_path / "a.mat", ["x"])


def test_a_damaged_matlab_file_is_one_line(tmp_path):
    whole = io.BytesIO()
    savemat(whole, {"x": np.arange(4.0)}, do_compression=True)
    for size in (0, 100, 130, 150):
        (tmp_path / "t.mat").write_bytes(whole.getvalue()[:size])
        says("expected ", read_mat, tmp_path / "t.mat", ["x"])


# MJCF


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><include file='/etc/passwd'/></mujoco>", "reads no other file, got file='/etc/passwd' in <include>"),
        ("<mujoco><asset><mesh file='a.stl'/></asset></mujoco>", "reads no other file"),
        ("<mujoco><compiler meshdir='/'/></mujoco>", "reads no other file, got meshdir='/' in <compiler>"),
        (
            "<mujoco><worldbody><replicate count='3000000'/></worldbody></mujoco>",
            "for themselves, got <replicate>",
        ),
        ("<mujoco><extension><plugin plugin='x'/></extension></mujoco>", "reads no other file, got <extension>"),
        ("<mujoco>" + "<body>" * 3000, "line 1: expected elements at most 32 deep"),
        ("<mujoco>" + "<geom/>" * 20_000, "expected at most 10,000 elements"),
        ("<!DOCTYPE m [<!ENTITY a 'aaaa'>]><mujoco/>", "without a document type"),
        ("<mujoco><asset><texture builtin='flat' width='99999' height='99999'/></asset></mujoco>", "16,777,216 pixels"),
        ("<mujoco><custom><numeric size='999999999'/></custom></mujoco>", "at most 10,000, got size='999999999'"),
        ("<mujoco><size memory='99G'/></mujoco>", "sizes that MuJoCo finds itself"),
        ("<robot/>", "expected <mujoco> outermost, got <robot>"),
        ("<mujoco", "expected XML, got: "),
        ("", "expected XML, got: "),
    ],
)
def test_mjcf_reads_no_other_file_and_is_bounded(text, message):
    says(message, checked_mjcf, text.encode(), "m.xml")


def test_mjcf_that_mujoco_refuses_is_one_line(tmp_path):
    (tmp_path / "m.xml").write_text("<mujoco><worldbody><body><geom size='-1'/></body></worldbody></mujoco>")
    says("m.xml: expected an MJCF model, got: ", compiled, tmp_path / "m.xml")


@pytest.mark.parametrize("rig", list(RIG_FILES))
def test_our_own_rigs_stand_alone(rig):
    assert checked_mjcf(mjcf(rig).encode(), rig) == mjcf(rig)


def test_every_file_is_read_through_the_one_way_in():
    """No module parses what a stranger hands over by itself."""
    root = Path(__file__).resolve().parent.parent
    calls = ("tomllib", "json.load", "read_csv(", "ParquetFile(", "read_table(source", "h5py.File", "loadmat(",
             "from_xml", "MjSpec.from_", "genfromtxt", "loadtxt", "pickle.load")  # fmt: skip
    own = {"imubench/inputs", "imubench/convert/table.py", "proof/added.py", "models"}
    # proof/added.py shares no code with the rest and reads what format 1 has read; models/ reads our rigs
    found = {
        f"{path.relative_to(root)}: {call}"
        for folder in ("imubench", "checks", "correction", "dataset", "diagnosis", "effects", "estimators", "models",
                       "proof", "reproduce", "scenarios", "sim", "sweeps", "trials")
        for path in (root / folder).rglob("*.py")
        for call in calls
        if call in path.read_text() and not any(str(path.relative_to(root)).startswith(o) for o in own)
    }  # fmt: skip
    assert not found

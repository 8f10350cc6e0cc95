"""docs/your-recordings.md from a logger's files to an estimate and a diagnosis, as it stands there."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from imubench.convert.csv import CONVERTER
from imubench.format1.keys import KEYS, LISTS
from imubench.library import load
from imubench.run import simulate
from imubench.simulation import Changes
from tests.command import here

PAGE = (Path(__file__).resolve().parent.parent / "docs" / "your-recordings.md").read_text()
(DECLARED,) = re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL)


def command(name: str) -> list[str]:
    """Return the words of the page's line that calls a command, behind `imubench`."""
    (line,) = re.findall(rf"^imubench ({name} (?:[^\\\n]|\\\n)*)$", PAGE, flags=re.MULTILINE)
    return shlex.split(line.replace("\\\n", " "), comments=True)


@pytest.fixture
def logged(tmp_path, monkeypatch):
    """The files of a logger that knows ms since 1970, deg/s and g, and has column names of its own."""
    monkeypatch.chdir(tmp_path)
    recording, _ = simulate("hinge-hand", 3, Changes(seconds=12.0))
    for letter, imu in zip("AB", recording.imus, strict=True):
        rows = np.column_stack([1e3 * imu.time + 1.7e12, np.rad2deg(imu.gyro), imu.accel / 9.80665])
        header = "Timestamp_ms,Gx,Gy,Gz,Ax,Ay,Az"
        np.savetxt(tmp_path / f"logger_{letter}.csv", rows, "%.6f", ",", header=header, comments="")
    return recording


def test_csv_files_of_a_logger_are_converted_declared_and_estimated(logged):
    done = here(*command("convert"))
    assert done.code == 0, done.err
    assert here(*command("estimate")).code == 0
    Path("arm/recording.toml").write_text(DECLARED)
    declared = load("arm")
    assert declared.imus[0].mount_position is not None
    for imu, was in zip(declared.imus, logged.imus, strict=True):
        np.testing.assert_allclose(imu.gyro, was.gyro, atol=1e-7)  # rad/s: six decimals of deg/s
    assert here(*command("estimate"), "--out", "again").code == 0


@pytest.mark.long
def test_they_are_diagnosed(logged):
    assert here(*command("convert")).code == 0
    done = here(*(word if word != "120" else "20" for word in command("diagnose")))
    assert done.code == 0, done.err
    assert json.loads(Path("diagnosis/diagnosis.json").read_text())["recording"] == "logger_A"


def test_columns_with_other_names_are_told_how_to_name_them(logged):
    """The first error of a new user: it said what was missing, and not what to type."""
    for words in ((), ("--option", "columns=time=Timestamp_ms"), ("--option", "rate=50")):
        done = here("convert", "csv", "logger_A.csv", *words, "--out", "out")
        assert done.code == 2
        assert done.err.rstrip().endswith("--option columns=time=T,gyr_x=X,... with the file's own names"), done.err


def test_every_option_of_csv_is_explained(logged):
    done = here("explain", "csv")
    assert done.code == 0
    for key, option in CONVERTER.options.items():
        assert f"--option {key}=...: {option.help}" in " ".join(done.out.split())


def test_the_page_names_every_table_and_key_of_a_recording():
    """Optional or not: what a reader of recording.toml understands can be looked up."""
    for table in LISTS:
        assert f"[[{table}]]" in PAGE
    for table, keys in KEYS.items():
        for key in keys:
            assert re.search(rf"\b{key}\b", PAGE), f"{table}.{key}"

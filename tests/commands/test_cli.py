"""The commands as a user calls them: what they write, and what they say about bad input."""

import json
from pathlib import Path

import numpy as np
import pytest

from imubench.format1 import read_recording, read_reference
from tests.command import here


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    done = here("run", "hinge-hand", "--seed", 5, "--out", "out", folder=folder)
    assert done.code == 0, done.err
    assert "deviation_imu1" in done.out
    return folder / "out"


@pytest.mark.long
def test_run_writes_score_recording_and_log(run):
    score = json.loads((run / "score.json").read_text())
    assert score["scenario"] == "hinge-hand"
    assert score["seed"] == 5
    assert score["estimator"] == "olsson2020"
    assert score["figures"]["maxae"]["unit"] == "rad"
    assert score["figures"]["maxae"]["value"] < np.deg2rad(3)
    assert (run / "run.rrd").stat().st_size > 100_000
    recording = read_recording(run / "recording")
    assert [imu.name for imu in recording.imus] == ["imu1", "imu2"]
    assert recording.imus[0].time.size == 60 * 50
    reference = read_reference(run / "recording")
    assert reference is not None
    assert reference.hinge_angle is not None


@pytest.mark.long
def test_estimate_on_disk_is_the_estimate_of_the_run(run, tmp_path):
    done = here("estimate", "olsson2020", run / "recording", "--out", "est", folder=tmp_path)
    assert done.code == 0, done.err
    on_disk = json.loads((tmp_path / "est" / "estimate.json").read_text())
    in_run = json.loads((run / "score.json").read_text())["estimate"]
    assert on_disk["value"] == in_run["value"]
    assert on_disk["beside_declared_mounts"].keys() == {"deviation_imu1", "deviation_imu2"}
    assert on_disk["beside_reference"]["deviation_imu1"]["value"] < np.deg2rad(0.5)
    assert (tmp_path / "est" / "run.rrd").exists()


@pytest.mark.long
def test_list_names_everything(tmp_path):
    done = here("list", "--json", folder=tmp_path)
    listed = json.loads(done.out)
    assert {"rigs", "scenarios", "estimators", "effects", "claims"} <= listed.keys()
    assert {"hinge", "pendulum", "free"} == {rig["name"] for rig in listed["rigs"]}
    assert {"olsson2020", "seel2012"} <= {e["name"] for e in listed["estimators"]}
    plain = here("list", folder=tmp_path).out
    assert "hinge-hand" in plain


def test_convert_csv_makes_a_readable_recording(tmp_path):
    t = np.arange(200) / 100
    rows = np.column_stack([t, *np.zeros((3, 200)), np.zeros(200), np.zeros(200), np.full(200, 9.81)])
    header = "time,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z"
    np.savetxt(tmp_path / "raw.csv", rows, delimiter=",", header=header, comments="")
    done = here("convert", "csv", "raw.csv", "--out", "rec", "--table", "parquet", folder=tmp_path)
    assert done.code == 0, done.err
    assert (tmp_path / "rec" / "imu1.parquet").exists()
    assert read_recording(tmp_path / "rec").imus[0].rate == pytest.approx(100)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("run", "hinge-hnd"), "unknown scenario 'hinge-hnd'; known: hinge-hand"),
        (("run", "hinge-hand", "--estimator", "olson"), "unknown estimator 'olson'; known: olsson2020"),
        (("run", "pendulum-rigid", "--estimator", "olsson2020"), "imu"),
        (("estimate", "olsson2020", "nowhere"), "nowhere"),
        (("convert", "diodm", "x"), "unknown format 'diodm'; known: diodem"),
        (("convert", "diodem", "x"), "expected a file or folder"),
        (("convert", "csv", "x", "--option", "rate"), "expected key=value"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(words, message, tmp_path):
    done = here(*words, "--out", "out", folder=tmp_path)
    assert done.code == 2
    assert message in done.err
    assert len(done.err.strip().splitlines()) == 1, done.err
    assert list(tmp_path.iterdir()) == []


def test_out_refuses_a_folder_with_other_peoples_files(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("years of work")
    done = here("run", "hinge-planar", "--out", "mine", folder=tmp_path)
    assert done.code == 2
    assert [p.name for p in tmp_path.rglob("*.*")] == ["thesis.txt"]

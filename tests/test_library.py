"""`import imubench as ib`: what it has, that nothing of it changes by accident, and that it does what it says."""

import importlib
import inspect
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import imubench as ib
from imubench.dataset import read as read_stored
from imubench.dataset.generate import generate
from imubench.dataset.shard import Job
from imubench.run import reference_of
from imubench.sim import imu_model
from imubench.sim.profiles import profile
from tests.public_names import ON_PURPOSE, WRITTEN, lines

PAGE = (Path(__file__).resolve().parent.parent / "docs/library.md").read_text()
BLOCKS = re.findall(r"```python\n(.*?)```", PAGE, flags=re.DOTALL)


@pytest.fixture(scope="module")
def simulated():
    return ib.simulate("hinge-planar", seed=1)


def test_the_public_names_are_those_that_were_written_down():
    assert lines() == WRITTEN.read_text().splitlines(), ON_PURPOSE


def test_a_name_that_changes_is_seen(monkeypatch):
    before = lines()
    monkeypatch.setattr(ib, "load", lambda source, more=1: None)
    assert set(lines()) - set(before) == {"load(source, more=1)"}
    monkeypatch.delattr(ib.Score, "deviation")
    assert set(before) - set(lines()) == {"load(source)", "Score.deviation(self, imu)"}


def test_the_names_stand_in_both_lists():
    assert set(ib.__all__) == set(ib.PUBLIC)


def test_the_page_lists_every_public_name():
    for line in lines():
        name, _, rest = line.partition("(")
        if "." in name:
            assert f"`.{name.rpartition('.')[2]}" in PAGE, name
        elif inspect.isclass(getattr(ib, name)):
            assert f"| `{name}` |" in PAGE
        else:
            assert f"| `ib.{name}({rest}` |" in PAGE


@pytest.mark.long
@pytest.mark.parametrize("number", range(len(BLOCKS)))
def test_what_the_page_shows_runs(number, tmp_path, monkeypatch):
    generate(
        Job({"spec.toml": b"seconds = 10\n[[rig]]\nfamily = 'pendulum'\n"}, 0, 4, str(tmp_path / "DIR")), workers=0
    )
    monkeypatch.chdir(tmp_path)
    exec(BLOCKS[number].replace("time_limit=600", "time_limit=5"), {})


def test_importing_it_imports_nothing_else():
    code = "import sys, imubench; print(*[m for m in ('numpy', 'mujoco', 'scipy', 'rerun') if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.strip() == ""


def test_what_it_has_is_listed_and_what_it_has_not_is_an_error():
    assert set(ib.__all__) <= set(dir(ib))
    with pytest.raises(AttributeError, match="module 'imubench' has no attribute 'simulat'"):
        _ = ib.simulat


@pytest.mark.parametrize("name", ["score", "estimate"])
def test_a_module_that_is_called_stays_a_module(name):
    module = importlib.import_module(f"imubench.{name}")
    called = getattr(ib, name)
    assert called is module and inspect.ismodule(called) and callable(called)
    home = importlib.import_module({"score": "imubench.score", "estimate": "imubench.run"}[name])
    assert inspect.signature(called) == inspect.signature(getattr(home, name))
    code = f"from imubench import {name}; import imubench; assert callable({name}) and imubench.{name} is {name}"
    subprocess.run([sys.executable, "-c", code], timeout=60, check=True)


def test_old_paths_lead_to_the_same():
    from imubench.estimate import Estimate
    from imubench.run import simulate
    from imubench.score import Score

    assert (Estimate, Score, simulate) == (ib.Estimate, ib.Score, ib.simulate)


def test_from_a_scenario_to_a_score(simulated):
    recording, truth = simulated
    estimate = ib.estimate("olsson2020", recording)
    judged = ib.score(estimate, truth)
    # A sign or a frame that is wrong makes a rad; how right it is, the tests of the estimators say.
    assert judged.figures["maxae"] < 0.05
    with pytest.raises(ib.InputError, match="unknown estimator 'olsson'; known: "):
        ib.estimate("olsson", recording)
    assert "olsson2020" in ib.known()["estimators"]


def test_a_truth_is_observed_by_any_imu(simulated):
    truth = simulated[1]
    mine = ib.observe(truth, "mpu9250", seed=3, name="mine")
    same = imu_model.observe(truth, profile("mpu9250"), np.random.default_rng(3), "mine")
    for a, b in zip(mine.imus, same.imus, strict=True):
        assert np.array_equal(a.gyro, b.gyro) and np.array_equal(a.time, b.time)
    mixed = ib.observe(truth, {"imu1": "mpu9250", "imu2": profile("perfect")}, np.random.default_rng(3))
    assert np.array_equal(mixed.imus[0].gyro, mine.imus[0].gyro)
    perfect = mixed.imus[1]
    rows = np.round(perfect.time / (truth.time[1] - truth.time[0])).astype(int)
    # A perfect IMU reads the truth; between its dense samples it is interpolated, far below 1e-6 rad/s.
    assert np.allclose(perfect.gyro, truth.sensor("imu2").gyro[rows], atol=1e-6)
    with pytest.raises(ib.InputError, match="unknown"):
        ib.observe(truth, "mpu")


def test_a_recording_is_loaded_by_its_name_and_its_reference_apart(tmp_path):
    spec = b"seconds = 2\nrecordings_per_rig = 1\n[[rig]]\nfamily = 'hinge'\n"
    generate(Job({"spec.toml": spec}, 0, 2, str(tmp_path / "d")), workers=0)
    recording, reference = ib.load(f"{tmp_path}/d#1"), ib.load_reference(f"{tmp_path}/d#1")
    stored = read_stored(tmp_path / "d", 1)
    assert np.array_equal(recording.imus[0].gyro, stored.recording.imus[0].gyro)
    assert reference is not None
    assert np.array_equal(reference.hinge_angle, reference_of(stored.truth, recording).hinge_angle)
    with pytest.raises(ib.InputError, match=r"expected a folder with recording\.toml"):
        ib.load(tmp_path / "none")


@pytest.mark.long
def test_a_diagnosis_is_that_of_the_command_without_its_files(tmp_path):
    spec = (
        b"seconds = 10\nrecordings_per_rig = 1\n[[rig]]\nfamily = 'pendulum'\n"
        b"[[effect]]\nname = 'gyro_bias'\nat = 'imu1'\nbias = [0.05, 0.08]\n"
    )
    generate(Job({"spec.toml": spec}, 0, 4, str(tmp_path / "d")), workers=0)
    before = sorted(tmp_path.rglob("*"))
    found = ib.diagnose(f"{tmp_path}/d#3")
    assert sorted(tmp_path.rglob("*")) == before
    assert found.alarm and "gyro_bias" in [f.effect for f in found.findings]
    assert found.fit.reference.before  # the truth of the dataset has judged it
    table = found.to_pandas()
    told = read_stored(tmp_path / "d", 3).effects[0]["parameters"]["bias"]
    values = table[(table["effect"] == "gyro_bias") & (table["parameter"] == "bias")]["value"].to_numpy()
    # The bias of the part itself is in it too: 0.005 rad/s an axis; three times that.
    assert np.allclose(values, told, atol=0.015)
    assert found.plot() is not None and "gyro_bias" in found._repr_html_()

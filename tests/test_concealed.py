"""The demo's last part: a recording whose truth lies apart is diagnosed, corrected for and drawn."""

import csv
import re
from dataclasses import replace
from importlib.resources import as_file, files

import numpy as np
import pytest
from PIL import Image

from imubench import concealed
from imubench.diagnosis.on_disk import Done
from imubench.diagnosis.report.picture import draw_diagnosis, most_visible
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.format1 import read
from imubench.inputs.toml import load_toml
from imubench.progress import silent
from imubench.rotations import conjugate, rotate
from imubench.run import OnDisk, estimate_on_disk
from imubench.terminal import Terminal
from scripts.concealed_recording import make
from tests.diagnosis.report.diagnoses import channel, simulated

AXES = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def shipped():
    with as_file(files("imubench.scenarios") / concealed.SHIPPED) as folder:
        yield folder


def shortened(table):
    """A table's text with numbers of ten digits: another machine's libm is right to the last of sixteen only."""
    return re.sub(r"(\d\.\d{10})\d+", r"\1", str(table))


def table(path):
    with path.open() as file:
        head, *rows = csv.reader(file)
    return head, np.array(rows, dtype=float)


def test_what_is_shipped_is_what_its_script_makes(shipped, tmp_path):
    make(tmp_path / "made")
    here, made = ({p.relative_to(f).as_posix() for p in f.rglob("*.*")} for f in (shipped, tmp_path / "made"))
    assert here == made == {"concealed.toml", *(f"recording/{n}" for n in ("recording.toml", "imu1.csv", "imu2.csv"))}
    for name in ("concealed.toml", "recording/recording.toml"):
        one, two = load_toml(shipped / name), load_toml(tmp_path / "made" / name)
        assert shortened(one) == shortened(two)
    for name in ("recording/imu1.csv", "recording/imu2.csv"):
        (head, rows), (again, others) = table(shipped / name), table(tmp_path / "made" / name)
        assert head == again
        np.testing.assert_allclose(rows, others, atol=1e-6)  # 9 digits are written; a spring's integration rounds


def test_it_is_small_and_nothing_in_the_recording_tells_the_truth(shipped):
    assert sum(p.stat().st_size for p in shipped.rglob("*")) < 400_000
    texts = "".join(p.read_text() for p in (shipped / "recording").iterdir())
    for effect in concealed.opened(shipped / "concealed.toml").effects:
        assert not [word for word in (effect["effect"], *effect["parameters"]) if word in texts]
    assert "reference" not in texts
    read(shipped / "recording")


def test_the_truth_is_near_the_declared_mounts_and_not_theirs(shipped):
    """Another way to the axes: mounts are declared within 0.02 rad (std, each axis), so four of them are enough."""
    truth, (recording, _) = concealed.opened(shipped / "concealed.toml"), read(shipped / "recording")
    for imu, axis in zip(recording.imus, truth.joint_axes, strict=True):
        away = np.arccos(rotate(conjugate(imu.mount_quaternion), [0.0, 1.0, 0.0]) @ axis)
        assert 1e-3 < away < 4 * 0.02


def test_what_is_concealed_spoils_the_axis(shipped, tmp_path):
    """Several degrees at both IMUs, or there would be nothing to put right."""
    before = estimate_on_disk(concealed.ESTIMATOR, shipped / "recording", tmp_path / "before")
    off, _ = concealed.off(concealed.Answer(None, before, before), concealed.opened(shipped / "concealed.toml"))
    assert np.all(off > 3.0)


@pytest.mark.long
def test_the_picture_is_drawn_whole_or_not_at_all(tmp_path):
    d, shown = simulated()
    draw_diagnosis(tmp_path / "a.png", d, shown, (np.array([7.0, 6.0]), np.array([0.2, 0.1])), "the true one")
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.width > 1000
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 100
    with pytest.raises(InputError, match="expected simulations to draw"):
        draw_diagnosis(tmp_path / "b.png", d, replace(shown, simulated=()), (np.ones(2), np.ones(2)), "the true one")
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_the_channel_that_is_drawn_is_of_the_sensor_at_fault_and_farthest_off_for_its_size():
    d, shown = simulated()
    loud, quiet, elsewhere = (
        channel("imu2.gyr_x", 0.5, 0.0),
        channel("imu2.acc_x", 0.1, 0.0),
        channel("imu1.gyr_x", 1, 0),
    )
    d = replace(d, findings=d.findings[:1])  # at imu2
    assert most_visible(d, replace(shown, simulated=(quiet, elsewhere, loud))) is loud
    assert most_visible(d, replace(shown, simulated=(elsewhere,))) is elsewhere


def test_the_truth_is_told_after_the_answer(shipped, capsys):
    d, shown = simulated()
    recording, _ = read(shipped / "recording")
    before = estimate_stub(recording, [[0.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
    answer = concealed.Answer(Done(d, shown), before, before)
    truth = concealed.Truth([{"effect": "soft_mount", "at": "imu2", "parameters": {"frequency": [11.0]}}], AXES)
    concealed.say_answer(answer, Terminal())
    told = capsys.readouterr().out
    assert "a soft mount that imu2 moves on as on springs" in told
    assert "imu2 accelerometer x" in told
    assert "Concealed" not in told
    concealed.say_truth(answer, truth, concealed.off(answer, truth), Terminal())
    told = capsys.readouterr().out
    assert re.search(r"as it is +converged +90\.00 +0\.00", told)
    assert re.search(r"frequency +11 +11\.2 +Hz", told)


def estimate_stub(recording, axes):
    """An estimate on disk of these axes (2, 3)."""
    estimate = Estimate("joint_axis", "olsson2020", np.array(axes), None, "converged", pairing="unknown")
    return OnDisk(recording, estimate, None, None)


@pytest.mark.slow
def test_the_axis_is_right_again(tmp_path, capsys):
    console = Terminal()
    concealed.show(tmp_path / "out", console, Terminal(stderr=True), silent)
    told = capsys.readouterr().out
    before, after = (re.search(rf"{row} +[a-z ]+ ([0-9.]+) +([0-9.]+)", told) for row in ("as it is", "taken out"))
    assert min(map(float, before.groups())) > 3.0
    assert max(map(float, after.groups())) < 0.5  # deg: five times what comes out, another machine rounds otherwise
    assert "The simulation leaves out a mount that imu2 rocks on." in told
    assert told.index("leaves out") < told.index("Concealed was a mount that imu2 rocks on")
    for name in ("concealed.png", "diagnosis/report.html", "diagnosis/model", "diagnosis/diagnosis.rrd"):
        assert (tmp_path / "out" / name).exists()
    assert not list((tmp_path / "out").rglob("concealed.toml"))

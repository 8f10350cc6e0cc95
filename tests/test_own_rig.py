"""A rig of one's own, an MJCF file beside the recording, passes the reader: what cannot take it says so in one line."""

import pytest

from imubench.diagnosis.pipeline import diagnose
from imubench.errors import InputError
from imubench.estimators import ESTIMATORS
from imubench.format1 import read, write_recording
from imubench.recording import Recording
from imubench.run import estimate_on_disk
from tests.command import here
from tests.commands.test_diagnose_cli import moved_hinge

MESSAGE = "key 'rig': expected hinge, pendulum, free for a diagnosis, got 'my.xml'"


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The folder of a recording of `my.xml`."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "my.xml").write_text("<mujoco/>")
    hinge = moved_hinge()[0]
    write_recording(Recording("own", "my.xml", hinge.imus), folder / "rec", rig_file=folder / "my.xml")
    return folder / "rec"


@pytest.mark.long
def test_a_diagnosis_of_it_is_one_line_and_no_key_error(own, tmp_path):
    with pytest.raises(InputError, match=r"for a diagnosis, got 'my\.xml'"):
        diagnose(read(own)[0])
    done = here("diagnose", own, "--out", "out", folder=tmp_path)
    assert done.code == 2
    assert MESSAGE in done.err
    assert len(done.err.strip().splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.long
def test_a_correction_by_a_diagnosis_is_refused_too(own, tmp_path):
    hinge = moved_hinge()[0]
    one, two = hinge.imus
    few = one.time[:2], one.gyro[:2], one.accel[:2]  # a diagnosis that takes no time
    short = Recording("own", "hinge", (type(one)("imu1", *few, one.rate), two))
    write_recording(short, tmp_path / "rec")
    assert here("diagnose", "rec", "--out", "said", folder=tmp_path).code == 0
    with pytest.raises(InputError, match=r"for a correction by its diagnosis, got 'my\.xml'"):
        estimate_on_disk("seel2012", own, tmp_path / "out", diagnosis=tmp_path / "said")


@pytest.mark.parametrize("name", ["seel2012", "olsson2020", "accel-svd", "hinge-position", "two-imu-centre"])
def test_estimators_take_it_as_they_take_a_hinge(own, name):
    """They ask for two IMUs, not for a rig."""
    recording = read(own)[0]
    found = ESTIMATORS[name].estimate(recording)
    assert len(found.value.reshape(-1, 2, 3)[-1]) == 2

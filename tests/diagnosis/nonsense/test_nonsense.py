"""Recordings with any real effect make sense."""

import pytest

from imubench.convert import CONVERTERS
from imubench.diagnosis.nonsense import nonsense
from imubench.diagnosis.nonsense.stretch import cut
from tests.diagnosis.nonsense.recordings import RIGS, said


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_clean_recording_of_any_rig_makes_sense(made, rig, seed):
    assert nonsense(made(rig, seed)) == ()


@pytest.mark.parametrize(
    ("rig", "effect"),
    [
        ("hinge", ("time_offset", "imu2")),
        ("hinge", ("low_pass", "imu1")),
        ("hinge", ("joint_play", "joint")),
        ("hinge", ("soft_mount", "imu2")),
        ("hinge", ("rocking_mount", "imu1")),
        ("hinge", ("mount_pose", "imu2")),
        ("hinge", ("saturation", "imu1")),
        ("hinge", ("quantisation", "imu2")),
        ("hinge", ("gyro_bias", "imu1")),
        ("hinge", ("skin_sliding", "imu2")),
        ("fixed", ("gyro_bias", "imu2")),
        ("swing", ("gyro_bias", "imu2")),
        ("swing", ("accel_misalignment", "imu2")),
        ("encoder", ("backlash", "joint")),
        ("pendulum", ("moving_pivot", "joint")),
        ("pendulum", ("g_sensitivity", "imu1")),
        ("free", ("time_offset", "imu1")),
    ],
)
def test_a_strong_effect_is_no_nonsense(made, rig, effect):
    assert nonsense(made(rig, 3, [effect])) == ()


@pytest.mark.long
def test_real_recordings_make_sense(recordings):
    """The six hinges of `diodem`, screwed on and on foam, and the six trials of `broad`, 30 s of each."""
    found = {}
    for kind in ("rigid", "nonrigid"):
        for joint in ("2-3", "3-4", "4-5"):
            (out,) = CONVERTERS["diodem"](recordings / "diodem" / "trial1", segments=joint, imu=kind)
            found[kind, joint] = nonsense(cut(out.recording, 20.0, 50.0))
    for path in sorted((recordings / "broad").glob("*.hdf5")):
        (out,) = CONVERTERS["broad"](path)
        found[path.name] = nonsense(cut(out.recording, 60.0, 90.0))
    assert len(found) == 12
    assert {name: said(n) for name, n in found.items() if n} == {}


def test_an_encoder_alone_makes_sense(swung):
    assert nonsense(swung({"dry_friction": 0.02}, 3.0)) == ()

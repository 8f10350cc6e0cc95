"""A diagnosis without one of the effects that it also uses inside: it must end, and not name what it does not have."""

import json
import subprocess
import sys

import pytest

from imubench.proof.case import make_case

BOTH = ["gyro", "accel"]
RUN = """
import sys
from imubench.trials.guard import take_out
name, recording, out = sys.argv[1:]
take_out(name)
from imubench.main import main
sys.argv = ["imubench", "diagnose", recording, "--out", out]
main()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rig", "effect"),
    [
        ("time_offset", "free", ("time_offset", "imu1", {"offset": 0.03})),
        ("low_pass", "hinge", ("low_pass", "imu2", {"cutoff": 60.0, "channels": BOTH})),
        ("mount_pose", "free", ("mount_pose", "imu1", {"rotation": [0.02, 0.03, -0.02], "translation": [0.0] * 3})),
        ("gravity", "pendulum", ("accel_scale", "imu1", {"scale": [0.01, 0.01, 0.01]})),
    ],
)
def test_an_effect_that_is_not_in_the_library_is_not_named_and_nothing_breaks(tmp_path, name, rig, effect):
    make_case(tmp_path / "case", rig, effects=[effect], seed=71, seconds=8.0)
    run = subprocess.run(
        [sys.executable, "-c", RUN, name, str(tmp_path / "case"), str(tmp_path / "out")],
        capture_output=True, text=True, check=False, timeout=600,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert name not in {f["effect"] for f in said["findings"]}

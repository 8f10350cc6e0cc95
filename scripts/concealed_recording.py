"""Make the recording with a concealed effect that the demo diagnoses, and the file that says what was concealed.

The generator in `proof/` makes it: it shares no code with the effects nor the diagnosis. The IMUs sit on a hinge that a
hand moves; under imu2 is soft foam.
"""

import shutil
from pathlib import Path

import tomli_w

from imubench.proof.case import make_case
from imubench.proof.rotation import from_quaternion

TARGET = Path(__file__).resolve().parent.parent / "scenarios" / "concealed_recording"
SEED = 44
FOAM = {
    "frequency": [7.0, 8.0, 6.0],  # Hz, about x, y, z of the sensor: softer than the foam of DIODEM, 9 to 17 Hz
    "damping_ratio": [0.08, 0.08, 0.08],
    "com": [0.0, 0.0, 0.004],  # m, above the pivot
    "gyration": 0.015,  # m
    "lever": [0.0, 0.0, 0.015],  # m, from the pivot to the sensing point
}
"""What is concealed: a `rocking_mount` of imu2."""
HEAD = "# What is true of recording/, by scripts/concealed_recording.py. joint_axes: of the hinge, in sensor axes."
OPTIONS = {"seconds": 8.0, "rate": 50.0, "rest": 0.2, "reference": False, "name": "concealed"}


def make(folder: Path) -> None:
    """Write recording/ and concealed.toml into the new folder `folder`."""
    truth = make_case(folder / "recording", "hinge", [("rocking_mount", "imu2", FOAM)], SEED, **OPTIONS)
    axes = [[round(float(x), 9) for x in from_quaternion(mount["quaternion"])[1]] for mount in truth["mounts"]]
    effects = [{key: effect[key] for key in ("effect", "at", "parameters")} for effect in truth["effects"]]
    text = tomli_w.dumps({"effects": effects, "joint_axes": axes})
    (folder / "concealed.toml").write_text(f"{HEAD}\n{text}")


def main() -> None:
    """Write scenarios/concealed_recording anew."""
    shutil.rmtree(TARGET, ignore_errors=True)
    make(TARGET)


if __name__ == "__main__":
    main()

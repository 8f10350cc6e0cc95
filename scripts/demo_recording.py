"""Make the small recording that the demo ships: 15 s of the scenario hinge-hand, digits cut to what an IMU gives."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np

from imubench.format1 import write_recording
from imubench.run import reference_of, simulate

TARGET = Path(__file__).resolve().parent.parent / "scenarios" / "demo_recording"
SECONDS = 15.0


def main() -> None:
    """Write scenarios/demo_recording anew."""
    recording, truth = simulate("hinge-hand", seed=7)
    imus = []
    for imu in recording.imus:
        early = imu.time < SECONDS
        gyro, accel = np.round(imu.gyro[early], 6), np.round(imu.accel[early], 5)
        imus.append(replace(imu, time=imu.time[early], gyro=gyro, accel=accel))
    reference = reference_of(truth, recording)
    early = reference.time < SECONDS
    columns = {k: None if v is None else np.round(v[early], 6) for k, v in vars(reference).items()}
    shutil.rmtree(TARGET, ignore_errors=True)
    write_recording(replace(recording, name="demo", imus=tuple(imus)), TARGET, replace(reference, **columns))


if __name__ == "__main__":
    main()

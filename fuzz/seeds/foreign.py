"""Sources of the converters in the layouts of their datasets, small: a CSV, DIODEM, BROAD, MultiArm-Pendulum."""

from pathlib import Path

import h5py
import numpy as np
from scipy.io import savemat

from fuzz.mutate.mat import untimed
from fuzz.seeds import laid_out
from imubench import rotations
from imubench.arrays import Array

RATE = 50.0  # Hz
SECONDS = 4.0
EPOCH = 1_700_000_000_000.0  # ms since 1970, as loggers count: more digits than a number in s holds
UP = np.array([0.0, 0.0, 9.81])  # m/s^2


def turned(time: Array) -> Array:
    """Return a smooth orientation (n, 4) body -> world that turns about several axes."""
    yaw = rotations.from_axis_angle(np.array([0.0, 0.0, 1.0]), 0.9 * np.sin(2.1 * time))
    return rotations.multiply(yaw, rotations.from_axis_angle(np.array([1.0, 0.0, 0.0]), 0.8 * np.sin(2.3 * time + 0.4)))


def readings(time: Array) -> tuple[Array, Array]:
    """Return rate and specific force (n, 3) of a body that turns on the spot, by central differences."""
    h = 1e-4
    before, now, after = (turned(t) for t in (time - h, time, time + h))
    rate = rotations.log(rotations.multiply(rotations.conjugate(before), after)) / (2 * h)
    return rate, rotations.rotate_back(now, np.broadcast_to(UP, (time.size, 3)))


def _csv(path: Path, columns: dict[str, Array], above: str = "") -> None:
    rows = np.stack(list(columns.values()), axis=1)
    lines = [",".join("" if np.isnan(x) else f"{x:.14g}" for x in row) for row in rows]
    path.write_text(above + "\n".join([",".join(columns), *lines]) + "\n", encoding="utf-8")


def _named(prefix: str, values: Array, letters: str = "xyz") -> dict[str, Array]:
    return {f"{prefix}_{letter}": values[:, k] for k, letter in enumerate(letters)}


@laid_out
def csv(folder: Path) -> None:
    """Write two CSV files, an IMU each, with names and units of their own, and the options that say so."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    gyro, accel = readings(time)
    for name in ("a.csv", "b.csv"):
        _csv(folder / name, {"t": EPOCH + time * 1e3} | _named("w", np.rad2deg(gyro)) | _named("a", accel / 9.80665))
    names = "time=t," + ",".join(
        f"{ours}_{c}={theirs}_{c}" for ours, theirs in (("gyr", "w"), ("acc", "a")) for c in "xyz"
    )
    options = (
        f"columns={names}", f"columns2={names}", "second=b.csv", "gyro_unit=deg/s", "accel_unit=g", "time_unit=ms",
        "rate=50", "rig=hinge",
    )  # fmt: skip
    (folder / "options.txt").write_text("\n".join(options), encoding="utf-8")


@laid_out
def diodem(folder: Path) -> None:
    """Write a trial of DIODEM's chain: two kinds of IMU tables and the optical one."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    quaternion, (gyro, accel) = turned(time), readings(time)
    head = f"# sampling frequency: {RATE:g}\n# units are seconds/meters/radians/a.u.\n"
    imus: dict[str, Array] = {}
    optical: dict[str, Array] = {}
    for k in range(1, 6):
        imus |= _named(f"seg{k}_acc", accel) | _named(f"seg{k}_gyr", gyro)
        seen = quaternion.copy()
        if k != 4:
            seen[50:55] = np.nan
        optical |= _named(f"seg{k}_quat", seen, "wxyz")
    (folder / "trial").mkdir()
    _csv(folder / "trial" / "imu_rigid.csv", imus, head)
    _csv(folder / "trial" / "imu_nonrigid.csv", imus, head)
    _csv(folder / "trial" / "omc.csv", optical, head)
    (folder / "options.txt").write_text("segments=3-4\nimu=rigid\noptical_delay=0.01", encoding="utf-8")


@laid_out
def broad(folder: Path) -> None:
    """Write a trial of BROAD."""
    time = np.arange(round(SECONDS * RATE)) / RATE
    gyro, accel = readings(time)
    quaternion = turned(time)
    quaternion[50:60] = np.nan
    arrays = {"imu_acc": accel, "imu_gyr": gyro, "opt_quat": quaternion, "opt_pos": np.zeros((time.size, 3))}
    with h5py.File(folder / "trial.hdf5", "w") as file:
        for key, array in (arrays | {"movement": (time > 1) & (time < 3)}).items():
            file[key] = array
        file.attrs["sampling_rate"] = RATE


@laid_out
def multiarm(folder: Path) -> None:
    """Write pieces of a single pendulum as cells of time, angle and rate."""
    cells: dict[str, list[Array]] = {"Time_id": [], "Y_id": [], "Time_vad": [], "Y_vad": []}
    for i, kind in enumerate(("id", "id", "vad")):
        time = 2.0 * i + np.arange(400) / 200
        angle, rate = np.pi + 0.8 * np.cos(5 * time), -4.0 * np.sin(5 * time)
        cells[f"Time_{kind}"].append(time[:, None])
        cells[f"Y_{kind}"].append(np.stack([angle, rate]))
    content: dict[str, object] = {"dt": 0.005}
    for key, values in cells.items():
        cell = np.empty((len(values), 1), dtype=object)
        for i, value in enumerate(values):
            cell[i, 0] = value
        content[key] = cell
    path = folder / "pendulum.mat"
    savemat(path, content)
    path.write_bytes(untimed(path.read_bytes()))
    (folder / "options.txt").write_text("piece=all", encoding="utf-8")

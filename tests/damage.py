"""A recording with everything in it, how a test breaks it in one place, and what is said of it then."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from imubench.errors import InputError
from imubench.format1 import read, write_recording
from imubench.recording import Body, Encoder, Imu, Pose, Recording
from imubench.reference import Reference

Edit = Callable[[np.ndarray], np.ndarray]
N = 1200  # samples at 100 Hz
TIME = np.arange(N) / 100


def tilting(name: str = "imu1", **facts: object) -> Imu:
    """A sensor that rests for 2 s and then tilts to and fro about x: exact, about 20 deg/s."""
    angle = np.where(TIME > 2, 0.5 * (1 - np.cos(TIME - 2)), 0.0)
    rate = np.where(TIME > 2, 0.5 * np.sin(TIME - 2), 0.0)
    zero = np.zeros(N)
    accel = 9.81 * np.stack([zero, np.sin(angle), np.cos(angle)], axis=1)
    return Imu(name, TIME, np.stack([rate, zero, zero], axis=1), accel, rate=100.0, **facts)


def whole(folder: Path) -> Path:
    """Write a recording with everything in it, which each test breaks in one place."""
    unit = np.tile([1.0, 0, 0, 0], (N, 1))
    recording = Recording(
        name="good",
        rig="hinge",
        imus=(tilting("imu1", gyro_range=35.0, accel_range=160.0), tilting("imu2")),
        encoders=(Encoder("hinge", TIME, 0.2 * np.sin(TIME)),),
        poses=(Pose("segment1", TIME, position=np.zeros((N, 3)), quaternion=unit),),
        free_swings=((1.0, 5.0),),
        body=Body(1.2, np.array([0, 0, -0.25]), np.array([0.03, 0.03, 0.002])),
    )
    reference = Reference(TIME, hinge_angle=0.2 * np.sin(TIME), quaternion1=unit)
    write_recording(recording, folder, reference)
    read(folder)
    return folder


def refused(folder: Path, *parts: str, by: Callable[[Path], object] = read) -> str:
    """Return the message of the one-line `InputError` that holds all `parts`."""
    with pytest.raises(InputError) as caught:
        by(folder)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    for part in parts:
        assert part in message
    return message


def swap(folder: Path, file: str, old: str, new: str) -> None:
    """Replace the one occurrence of a text in a file."""
    text = (folder / file).read_text()
    assert text.count(old) == 1, f"{old!r} stands {text.count(old)} times in {file}"
    (folder / file).write_text(text.replace(old, new))


def set_line(folder: Path, file: str, line: int, new: str | None) -> None:
    """Replace one line of a file, counted from 1 as an editor does, or with None remove it."""
    lines = (folder / file).read_text().splitlines()
    lines[line - 1 : line] = [] if new is None else [new]
    (folder / file).write_text("\n".join(lines) + "\n")


def set_cell(folder: Path, file: str, line: int, column: str, new: str) -> None:
    lines = (folder / file).read_text().splitlines()
    cells = lines[line - 1].split(",")
    cells[lines[0].split(",").index(column)] = new
    set_line(folder, file, line, ",".join(cells))


def change(folder: Path, name: str, columns: str, edit: Edit) -> None:
    """Send the columns of one CSV that start with `columns` through `edit`."""
    path = folder / name
    header = path.read_text().splitlines()[0].split(",")
    values = np.genfromtxt(path, delimiter=",", skip_header=1)
    chosen = [k for k, column in enumerate(header) if column.startswith(columns)]
    values[:, chosen] = edit(values[:, chosen])
    np.savetxt(path, values, delimiter=",", header=",".join(header), comments="", fmt="%.17g")

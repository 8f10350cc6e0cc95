"""Recordings in format 1: a hinge with every kind of sensor, as CSV, as Parquet, and with a rig of its own."""

import os
import shutil
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Literal

import numpy as np

from fuzz.seeds import STAMP, laid_out
from imubench.atomic import MARKER, atomic_directory
from imubench.dataset import make, parse_spec
from imubench.format1 import write_recording
from imubench.models import mjcf
from imubench.recording import Body, Recording
from imubench.reference import Reference

KNEE = """<mujoco>
  <worldbody>
    <body name="thigh" pos="0 0 1">
      <freejoint/>
      <geom type="capsule" fromto="0 0 0.4 0 0 0.02" size="0.06" mass="7"/>
      <site name="upper" pos="0.07 0 0.2" euler="0 90 0"/>
      <body name="shank">
        <joint name="knee" axis="1 0.1 0"/>
        <geom type="capsule" fromto="0 0 -0.02 0 0 -0.38" size="0.045" mass="3"/>
        <site name="lower" pos="0.05 0 -0.15" euler="0 0 30"/>
      </body>
    </body>
  </worldbody>
  <sensor>
    <gyro site="upper"/><accelerometer site="upper"/><gyro site="lower"/><accelerometer site="lower"/>
  </sensor>
</mujoco>
"""

SPEC = b"""
seconds = 3
rate = 50
precision = "double"
[[rig]]
family = "hinge"
[encoder]
[[pose]]
"""


@lru_cache(maxsize=1)
def recorded() -> tuple[Recording, Reference]:
    """Return a simulated hinge with two IMUs, an encoder and a pose, and its reference."""
    made = make(parse_spec({"spec.toml": SPEC}), 3, 0)
    truth, time = made.truth, made.recording.imus[0].time
    body = Body(1.2, np.array([0.1, 0.0, 0.0]), np.array([0.01, 0.03, 0.03]))
    imus = tuple(replace(imu, gyro_range=35.0, accel_range=160.0) for imu in made.recording.imus)
    whole = replace(made.recording, name="seed", imus=imus, body=body, free_swings=((0.5, 1.5),))
    rows = np.isin(np.round(truth.time * 1_000), np.round(time * 1_000))
    segments = [s.quaternion[rows] for s in truth.segments]
    position, angle = truth.segments[0].position[rows], truth.joint_angle
    return whole, Reference(truth.time[rows], None if angle is None else angle[rows], *segments, position)


def write(folder: Path, table: Literal["csv", "parquet"] = "csv", name: str = "seed") -> None:
    """Write the recording, without the mark of its folder, which is no part of it."""
    recording, reference = recorded()
    write_recording(replace(recording, name=name), folder, reference, table)
    (folder / MARKER).unlink()


@laid_out
def as_csv(folder: Path) -> None:
    """Write the recording with CSV files."""
    write(folder)


@laid_out
def as_parquet(folder: Path) -> None:
    """Write the recording with Parquet files."""
    write(folder, "parquet")


@laid_out
def with_rig(folder: Path) -> None:
    """Write a recording whose rig is an MJCF file beside it."""
    recording, reference = recorded()
    rig = folder / "rig.xml"
    rig.write_text(mjcf("hinge"), encoding="utf-8")
    out = folder / "recording"
    write_recording(replace(recording, rig="my.xml"), out, reference, rig_file=rig)
    for file in out.iterdir():
        file.rename(folder / file.name)
    out.rmdir()
    for name in (MARKER, rig.name):
        (folder / name).unlink()


@laid_out
def of_a_package(folder: Path) -> None:
    """Write the MJCF file of a rig that a package offers."""
    (folder / "theirs.xml").write_text(KNEE, encoding="utf-8")


@laid_out
def marked(folder: Path) -> None:
    """Write a result as `--out` leaves it, with the mark that lets the next run replace it.

    The mark has every file's time of change, which is `STAMP` wherever an input is laid out.
    """
    write(folder / "out")
    for file in (folder / "out").iterdir():
        os.utime(file, ns=(STAMP, STAMP))
    with atomic_directory(folder / "again") as again:
        shutil.copytree(folder / "out", again, dirs_exist_ok=True)  # with the times of change
    (folder / "again" / MARKER).rename(folder / "out" / MARKER)
    shutil.rmtree(folder / "again")

"""What a diagnosis wrote: diagnosis.json, which an estimate takes, and the folder model/, which is played again."""

from pathlib import Path

import numpy as np

from fuzz.mutate import csv, json, mjcf, toml
from fuzz.reader import Reader
from fuzz.seeds import models
from imubench import format1
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.sensor_errors.baseline import Learned, check_same_sensors, check_usable
from imubench.diagnosis.simulation.model_folder import check_same, replay

SELDOM = 200  # inputs to a whole command that fits a motion, which takes seconds


def told(f: Path, o: Path) -> object:
    """Read a diagnosis."""
    return read_diagnosis(f / "diagnosis")


def beside(f: Path, o: Path) -> object:
    """Read a diagnosis as another recording's baseline."""
    read = read_diagnosis(f / "diagnosis")
    check_usable(read, f / "diagnosis")
    check_same_sensors(read, format1.read_recording(f / "recording"))
    return Learned.of(read).hypotheses


def same(f: Path, o: Path) -> object:
    """Check that a diagnosis is one of a recording."""
    return check_same(f / "diagnosis" / "model", format1.read_recording(f / "recording"))


def corrected(f: Path, o: Path) -> list[str]:
    """Return the words of an estimate without what a diagnosis found."""
    return ["estimate", "seel2012", str(f / "recording"), "--with", str(f / "diagnosis"), "--out", str(o)]


def played(f: Path, o: Path) -> object:
    """Play a model."""
    return replay(f / "model", np.random.default_rng(0))


def run(f: Path, o: Path) -> list[str]:
    """Return the words that play a model."""
    return ["run", str(f / "model"), "--out", str(o)]


READERS = (
    Reader(
        *("diagnosis-json", "diagnosis/diagnosis.json", models.diagnosed, json.mutate, told, corrected), every=SELDOM
    ),
    Reader("diagnosis-baseline", "diagnosis/diagnosis.json", models.diagnosed, json.mutate, beside),
    Reader(
        *("diagnosis-imus-toml", "diagnosis/model/imus.toml", models.diagnosed, toml.mutate, same, corrected),
        every=SELDOM,
    ),
    Reader("model-imus-toml", "model/imus.toml", models.model, toml.mutate, played, run),
    Reader("model-motion-csv", "model/motion.csv", models.model, csv.mutate, played, run),
    Reader("model-unknown-csv", "model/unknown_imu1.csv", models.model, csv.mutate, played, run),
    Reader("model-mjcf", "model/hinge.xml", models.model, mjcf.mutate, played, run),
)

"""Data flows one way, every package is listed, and everything in a registry can be used."""

import ast
import tomllib
from pathlib import Path

import numpy as np
import pytest

from imubench.models import RIG_FILES
from imubench.models.tree import rig_tree
from imubench.run import simulate
from imubench.sim.compile import compile_model
from imubench.sim.rigs import standard_rig
from tests.scenarios import EVERY

ROOT = Path(__file__).resolve().parent.parent
SETUP = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def imports(source: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return found


def test_every_folder_with_code_is_a_listed_package():
    tops = (
        "imubench",
        "models",
        "sim",
        "estimators",
        "scenarios",
        "reproduce",
        "effects",
        "correction",
        "diagnosis",
        "proof",
        "trials",
        "dataset",
        "sweeps",
        "checks",
    )
    folders = {p.parent.relative_to(ROOT).as_posix() for top in tops for p in (ROOT / top).rglob("*.py")}
    assert folders == set(SETUP["package-dir"].values())
    assert set(SETUP["packages"]) == set(SETUP["package-dir"])


@pytest.mark.parametrize("source", sorted((ROOT / "estimators").glob("*.py")), ids=lambda p: p.name)
def test_estimators_never_see_the_truth_nor_its_maker(source):
    forbidden = ("imubench.truth", "imubench.reference", "imubench.sim", "imubench.scenarios", "imubench.score")
    assert not [name for name in imports(source) if name.startswith(forbidden)]


@pytest.mark.parametrize("source", sorted((ROOT / "sim").glob("*.py")), ids=lambda p: p.name)
def test_the_simulator_knows_no_estimator(source):
    assert not [
        n for n in imports(source) if n.startswith(("imubench.estimators", "imubench.estimate", "imubench.scenarios"))
    ]


def test_no_module_is_longer_than_400_lines():
    sources = [p for folder in SETUP["package-dir"].values() for p in (ROOT / folder).glob("*.py")]
    assert not [p for p in sources if len(p.read_text().splitlines()) > 400]


@pytest.mark.parametrize("family", list(RIG_FILES))
def test_every_rig_compiles_with_its_sensors(family):
    model = compile_model(standard_rig(family))
    names = {model.sensor(i).name for i in range(model.nsensor)}
    for imu, segment in rig_tree(family).carriers.items():
        assert {f"{segment}_framepos", f"{imu}_accelerometer", f"{imu}_gyro"} <= names


@pytest.mark.parametrize("name", EVERY)
def test_every_scenario_plays_and_repeats_by_seed(name):
    recording, truth = simulate(name, seed=3)
    again, _ = simulate(name, seed=3)
    other, _ = simulate(name, seed=4)
    assert recording.rig == truth.rig
    assert [imu.name for imu in recording.imus] == [s.name for s in truth.sensors]
    assert np.array_equal(recording.imus[-1].gyro, again.imus[-1].gyro)
    assert not np.array_equal(recording.imus[-1].gyro, other.imus[-1].gyro)
    for imu in recording.imus:
        assert imu.gyro_range is None or np.abs(imu.gyro).max() < imu.gyro_range

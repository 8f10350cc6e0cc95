"""The independent generator: alone in its imports, repeatable, readable, silent about its truth, and quick."""

import ast
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from imubench import format1
from imubench.cli import app
from imubench.effects import EFFECTS
from imubench.proof.case import build, make_case
from imubench.proof.filed import write
from imubench.proof.options import Options
from imubench.proof.ranges import SIZES, places
from imubench.proof.told import truth
from imubench.proof.unknown_ranges import UNKNOWN, unknown_places
from imubench.proof.write import write_folder

FOLDER = Path(__file__).resolve().parent.parent / "proof"
HIDDEN = ("__import__", "eval", "exec")  # ways to import that the walk would not see
RIGS = {
    "hinge": {"rig": "hinge"},
    "hinge with two rates": {"rig": "hinge", "rate": 128.0, "rate2": 60.0, "encoder": True, "pose": True},
    "fixed hinge": {"rig": "hinge", "base": "fixed", "encoder": True},
    "swinging hinge": {"rig": "hinge", "base": "fixed", "swing": True, "encoder": True},
    "pendulum": {"rig": "pendulum"},
    "swinging pendulum": {"rig": "pendulum", "swing": True},
    "free body": {"rig": "free"},
}


def imported(source: Path) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(source.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found |= {"." * node.level + str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)}
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in HIDDEN:
            found.add(node.func.id)
    return found


@pytest.mark.parametrize("source", sorted(FOLDER.glob("*.py")), ids=lambda p: p.name)
def test_the_generator_imports_nothing_but_numpy_scipy_and_itself(source):
    for name in imported(source):
        top = name.split(".")[0]
        assert top in ("numpy", "scipy") or name.startswith("imubench.proof") or top in sys.stdlib_module_names
        assert top != "importlib"


@pytest.mark.parametrize("folder", ["correction", "diagnosis", "effects", "sim", "estimators"])
def test_what_is_on_trial_knows_nothing_of_the_generator(folder):
    for source in (FOLDER.parent / folder).rglob("*.py"):
        assert not [name for name in imported(source) if name.startswith(("imubench.proof", "proof"))]


@pytest.mark.parametrize("name", list(RIGS))
def test_every_rig_is_read_and_repeats_by_seed(name, tmp_path):
    options = {"seconds": 12.0, **RIGS[name]}
    truth = make_case(tmp_path / "a", seed=5, gaps=1, repeats=3, **options)
    assert make_case(tmp_path / "b", seed=5, gaps=1, repeats=3, **options) == truth
    make_case(tmp_path / "c", seed=6, gaps=1, repeats=3, **options)
    files = sorted(p.name for p in (tmp_path / "a").iterdir())
    assert [(tmp_path / "a" / f).read_bytes() for f in files] == [(tmp_path / "b" / f).read_bytes() for f in files]
    assert (tmp_path / "a" / "imu1.csv").read_bytes() != (tmp_path / "c" / "imu1.csv").read_bytes()
    recording, reference = format1.read(tmp_path / "a")
    assert recording.rig == options["rig"] and reference is not None
    assert len(recording.encoders) == options.get("encoder", False)
    assert bool(recording.free_swings) == options.get("swing", False) == (recording.body is not None)
    assert bool(recording.poses) == (name in ("free body", "hinge with two rates"))
    for imu, rate in zip(recording.imus, (options.get("rate", 100.0), options.get("rate2", 100.0)), strict=False):
        assert imu.rate == rate and abs(imu.time.size - 12 * rate) < 0.06 * 12 * rate  # a gap and 0.3 % of the clock
    json.dumps(truth)


def test_the_recording_tells_nothing_of_the_truth(tmp_path):
    make_case(tmp_path / "plain", seed=2, seconds=8)
    make_case(tmp_path / "with", effects=[("gyro_bias", "imu2"), ("soft_mount", "imu1")], seed=2, seconds=8)
    assert sorted(p.name for p in (tmp_path / "with").iterdir()) == sorted(
        p.name for p in (tmp_path / "plain").iterdir()
    )
    assert (tmp_path / "with" / "recording.toml").read_text() == (tmp_path / "plain" / "recording.toml").read_text()
    assert (tmp_path / "with" / "reference.csv").read_text() == (tmp_path / "plain" / "reference.csv").read_text()


def all_of(rig):
    chosen = Options(**RIGS[rig])
    return places(chosen) | unknown_places(chosen)


@pytest.mark.long
@pytest.mark.parametrize("rig", [rig for rig in RIGS if rig != "hinge with two rates"])
def test_every_effect_changes_what_it_should_on_every_rig_it_fits(rig, tmp_path):
    options = {"seconds": 5.0, **RIGS[rig]}
    plain = build(seed=7, **options)
    for name, at in ((name, at) for name, ats in all_of(rig).items() for at in ats):
        case = build(effects=[(name, at)], seed=7, strength="strong", **options)
        assert [(e.effect, e.at, e.inside) for e in case.effects] == [(name, at, name in SIZES)]
        changed = [
            a.gyro.shape != b.gyro.shape or not np.array_equal(a.gyro, b.gyro) or not np.array_equal(a.accel, b.accel)
            for a, b in zip(case.imus, plain.imus, strict=True)
        ]
        if at.startswith("imu"):
            assert [f"imu{i + 1}" for i, there in enumerate(changed) if there] == [at], name
        else:
            assert any(changed) or name == "backlash", name
        write(case, tmp_path / f"{name} {at}")
        format1.read(tmp_path / f"{name} {at}")
        json.dumps(truth(case))


def test_every_effect_of_the_table_and_of_the_unknown_is_drawn_somewhere():
    assert {name for rig in RIGS for name in all_of(rig)} == {*SIZES, *UNKNOWN}
    assert set(SIZES) == set(EFFECTS)  # the generator shares no code with the library, and has a size for each effect


@pytest.mark.parametrize(("name", "estimator"), [("hinge", "olsson2020"), ("pendulum", "mrvs")])
def test_estimators_run_on_what_it_writes(name, estimator, tmp_path):
    make_case(tmp_path / "recording", seed=5, seconds=30.0, **RIGS[name])
    done = CliRunner().invoke(app, ["estimate", estimator, str(tmp_path / "recording"), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "out" / "estimate.json").exists()


def test_bad_questions_are_answered_in_one_line(tmp_path):
    with pytest.raises(ValueError, match=r"unknown rig 'chain'; known: hinge"):
        make_case(tmp_path / "a", "chain")
    with pytest.raises(ValueError, match=r"unknown effect 'gremlins'; known: gyro_bias"):
        make_case(tmp_path / "a", effects=[("gremlins", "imu1")])
    with pytest.raises(ValueError, match=r"unknown strength 'huge'"):
        make_case(tmp_path / "a", effects=[("gyro_bias", "imu1")], strength="huge")
    with pytest.raises(ValueError, match=r"a swing needs"):
        make_case(tmp_path / "a", swing=True)
    (tmp_path / "a").mkdir()
    with pytest.raises(FileExistsError):
        make_case(tmp_path / "a", seconds=3)


def test_a_recording_that_cannot_be_written_leaves_nothing(tmp_path):
    """`prove` writes one into a folder that it keeps to go on from."""
    table = {"name": "imu1", "file": "imu1.csv", "columns": {"time": np.arange(3.0)}}
    with pytest.raises(OSError, match="No such file"):
        write_folder(tmp_path / "a", {}, {"imu": [table, {"file": "nowhere/imu2.csv", "columns": table["columns"]}]})
    assert list(tmp_path.iterdir()) == []

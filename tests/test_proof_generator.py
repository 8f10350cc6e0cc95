"""The independent generator: alone in its imports, repeatable, readable, silent about its truth, and quick."""

import ast
import json
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from imubench import format1
from imubench.proof.case import make_case
from imubench.proof.options import Options
from imubench.proof.ranges import SIZES, places
from imubench.proof.unknown_ranges import UNKNOWN, unknown_places

FOLDER = Path(__file__).resolve().parent.parent / "proof"
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
            assert node.level == 0
            found.add(str(node.module))
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in ("__import__", "eval", "exec")
    return found


@pytest.mark.parametrize("source", sorted(FOLDER.glob("*.py")), ids=lambda p: p.name)
def test_the_generator_imports_nothing_but_numpy_scipy_and_itself(source):
    for name in imported(source):
        top = name.split(".")[0]
        assert top in ("numpy", "scipy") or name.startswith("imubench.proof") or top in sys.stdlib_module_names
        assert top != "importlib"


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


ALL = [(rig, name) for rig in RIGS for name in (*places(Options(**RIGS[rig])), *unknown_places(Options(**RIGS[rig])))]


@pytest.mark.parametrize(("rig", "name"), ALL, ids=lambda x: x)
def test_every_effect_changes_the_recording_of_every_rig_it_fits(rig, name, tmp_path):
    options = {"seconds": 12.0, **RIGS[rig]}
    chosen = Options(**options)
    at = (places(chosen) | unknown_places(chosen))[name][-1]
    make_case(tmp_path / "plain", seed=7, **options)
    truth = make_case(tmp_path / "with", effects=[(name, at)], seed=7, strength="strong", **options)
    assert [(e["effect"], e["at"], e["inside"]) for e in truth["effects"]] == [(name, at, name in SIZES)]
    recording = format1.read_recording(tmp_path / "with")
    plain = format1.read_recording(tmp_path / "plain")
    changed = []
    for a, b in zip((*recording.imus, *recording.encoders), (*plain.imus, *plain.encoders), strict=True):
        values = [(x.gyro, x.accel) if hasattr(x, "gyro") else (x.angle,) for x in (a, b)]
        changed.append(any(p.shape != q.shape or not np.array_equal(p, q) for p, q in zip(*values, strict=True)))
    assert any(changed)
    if at.startswith("imu"):  # and no other sensor
        assert [i for i, there in enumerate(changed) if there] == [int(at[-1]) - 1]


def test_every_effect_of_the_table_and_of_the_unknown_is_drawn_somewhere():
    assert {name for _, name in ALL} == {*SIZES, *UNKNOWN}


def test_a_minute_at_100_hz_takes_under_two_seconds(tmp_path):
    start = time.perf_counter()
    make_case(tmp_path / "a", effects=[("soft_mount", "imu2")], seed=1)
    assert time.perf_counter() - start < 2.0


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

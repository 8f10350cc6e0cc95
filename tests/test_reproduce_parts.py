"""The parts of a paper's work, kept and computed side by side."""

from pathlib import Path

import numpy as np
import pytest

from imubench.reproduce.olsson2020 import experiments
from imubench.reproduce.paper import Part
from imubench.reproduce.parts import Store, run_parts
from tests.papers import counted


def failing() -> dict[str, np.ndarray]:
    raise ArithmeticError("no")


def counting_parts(log: Path, count: int = 3) -> list[Part]:
    return [Part(f"p{n}", "count", 1.0, counted, {"n": n, "log": str(log)}) for n in range(count)]


def test_finished_parts_are_not_computed_again(tmp_path):
    log, store, seen = tmp_path / "log", Store(tmp_path / "out", "settings"), []
    parts = counting_parts(log)
    with pytest.raises(ArithmeticError):
        run_parts([*parts[:2], Part("bad", "fail", 1.0, failing, {})], store, 0, lambda part: seen.append(part.name))
    assert seen == ["p0", "p1"]
    done = run_parts(parts, store, 0, lambda part: seen.append(part.name))
    assert {name: int(arrays["square"][0]) for name, arrays in done.items()} == {"p0": 0, "p1": 1, "p2": 4}
    assert log.read_text().split() == ["0", "1", "2"]
    assert seen == ["p0", "p1", "p0", "p1", "p2"]


def test_other_settings_and_broken_files_are_computed(tmp_path):
    log, out = tmp_path / "log", tmp_path / "out"
    parts = counting_parts(log, 1)
    first = Store(out, "settings")
    run_parts(parts, first, 0, lambda part: None)
    run_parts(parts, Store(out, "other settings"), 0, lambda part: None)
    assert log.read_text().split() == ["0", "0"]
    next(first.folder.glob("*.npz")).write_bytes(b"half a file")
    run_parts(parts, first, 0, lambda part: None)
    assert log.read_text().split() == ["0", "0", "0"]
    first.forget()
    Store(out, "third settings").forget()
    assert [p.name for p in tmp_path.iterdir()] == ["log", ".out.parts"]  # those of the second may be gone on with
    Store(out, "other settings").forget()
    assert [p.name for p in tmp_path.iterdir()] == ["log"]


@pytest.mark.long
def test_processes_give_what_one_process_gives(tmp_path):
    arguments = {"seed": 3, "number": 5, "w0": np.array([1.0, 50.0]), "starts": 4}
    parts = [Part(f"w{n}", "weights", 1.0, experiments.weighting, {**arguments, "number": n}) for n in (5, 6)]
    here = run_parts(parts, Store(tmp_path / "a", ""), 0, lambda part: None)
    there = run_parts(parts, Store(tmp_path / "b", ""), 2, lambda part: None)
    for name in here:
        # One thread of linear algebra or several may round sums differently; errors are 1e-4 rad.
        np.testing.assert_allclose(here[name]["deviation"], there[name]["deviation"], atol=1e-9)

"""Every notebook runs from its first cell to its last, shows something, and has no output stored in it."""

import importlib.util
from pathlib import Path

import marimo
import matplotlib
import pandas as pd
import pytest

FOLDER = Path(__file__).resolve().parent.parent / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.py"))


@pytest.fixture(scope="module")
def ran():
    """Return a function that runs a notebook once: its outputs, and what its cells define."""
    done: dict[str, tuple[tuple[object, ...], dict[str, object]]] = {}
    matplotlib.use("agg")

    def run(name: str):
        if name not in done:
            spec = importlib.util.spec_from_file_location(f"notebook_{name}", FOLDER / f"{name}.py")
            module = importlib.util.module_from_spec(spec)
            spec.loader.exec_module(module)
            assert isinstance(module.app, marimo.App)
            outputs, defined = module.app.run()
            done[name] = tuple(outputs), dict(defined)
        return done[name]

    return run


def test_each_use_and_the_diagnosis_have_one():
    assert [path.stem for path in NOTEBOOKS] == ["dataset", "diagnosis", "estimator", "soft_tissue"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_is_small_and_holds_no_output(path):
    text = path.read_text()
    assert len(text) < 8000 and "__generated_with" not in text and "base64" not in text


@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_it_runs_and_shows_something(path, ran):
    outputs, _ = ran(path.stem)
    assert sum(output is not None for output in outputs) >= 4


@pytest.mark.long
def test_the_estimator_is_right_where_the_axis_rests_and_wrong_where_it_moves(ran):
    table = ran("estimator")[1]["table"]["principal-rate"]
    assert table["hinge-planar"].max() < 5 < table["hinge-hand"].max()  # as the text says; deg


@pytest.mark.long
def test_softer_mounts_are_worse(ran):
    table = ran("soft_tissue")[1]["table"]
    assert isinstance(table, pd.DataFrame) and list(table.index) == [4.0, 7.0, 12.0, 25.0]
    assert (table.loc[4.0] > table.loc[25.0]).all()


@pytest.mark.long
def test_the_test_split_is_scored(ran):
    defined = ran("dataset")[1]
    tested = set(defined["recordings"].query("split == 'test'").index)
    assert tested and set(defined["errors"]["recording"]) == tested


@pytest.mark.long
def test_what_is_concealed_is_found(ran):
    assert ran("diagnosis")[1]["missed"] == []

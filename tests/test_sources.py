"""A recording is named the same way everywhere: by its folder, or as DIR#17 of a dataset."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from imubench.atomic import check_apart
from imubench.dataset import read as read_stored
from imubench.dataset.generate import generate
from imubench.dataset.shard import Job
from imubench.errors import InputError
from imubench.format1 import read as read_folder
from imubench.run import reference_of
from imubench.sources import folder_of, in_dataset, label, read
from tests.command import here

SPEC = """
seconds = [8, 9]
recordings_per_rig = 1
recordings_per_file = 3
[[rig]]
family = "hinge"
[[rig]]
family = "hinge"
base = "fixed"
[[rig]]
family = "pendulum"
[[rig]]
family = "free"
[encoder]
[[pose]]
[[motion]]
kind = "random"
[[motion]]
kind = "swing"
[[effect]]
name = "dropouts"
probability = 0.5
fraction = 0.1
[[effect]]
name = "time_offset"
probability = 0.5
"""
COUNT, SEED = 10, 7


def made(out: Path, text: str = SPEC, count: int = COUNT, seed: int = SEED) -> Path:
    generate(Job({"spec.toml": text.encode()}, seed, count, str(out)), workers=0)
    return out


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    return made(tmp_path_factory.mktemp("sources") / "d")


def same(one, other):
    """Two dataclasses, or tuples of them, with the same numbers."""
    if one is None or isinstance(one, str | float | int):
        assert one == other
    elif isinstance(one, np.ndarray):
        assert np.array_equal(one, other, equal_nan=True)
    elif isinstance(one, tuple):
        assert len(one) == len(other)
        for a, b in zip(one, other, strict=True):
            same(a, b)
    else:
        assert type(one) is type(other)
        for name in one.__dataclass_fields__:
            same(getattr(one, name), getattr(other, name))


@pytest.mark.parametrize("index", range(COUNT))
def test_a_recording_of_a_dataset_comes_with_its_truth_as_reference(dataset, index):
    recording, reference = read(f"{dataset}#{index}")
    stored = read_stored(dataset, index)
    same(recording, stored.recording)
    assert stored.truth.time.size == stored.row["samples"]
    same(reference, reference_of(stored.truth, recording))


def test_as_a_folder_it_is_the_same_recording(dataset, tmp_path):
    done = here("export", "format1", dataset, "--out", tmp_path / "all")
    assert done.code == 0 and f"{COUNT} recordings written" in done.out
    for index in range(COUNT):
        recording, reference = read(Path(f"{dataset}#{index}"))
        written = read_folder(tmp_path / "all" / recording.name)
        same(written, (recording, reference))


def test_one_recording_is_exported_and_the_form_may_be_an_option(dataset, tmp_path):
    done = here("export", "--form", "format1", f"{dataset}#3", "--out", tmp_path / "one")
    assert done.code == 0 and "1 recordings written" in done.out
    assert [path.name for path in (tmp_path / "one").iterdir() if path.is_dir()] == ["dataset-0000003"]
    for words, said in (
        (("format1", f"{dataset}#3", "--split", "train"), "expected one recording without --split"),
        (("format1", dataset, "more"), "expected a form and one dataset, got format1"),
        (("format1",), "expected a form and one dataset, got format1"),
        (("formatone", dataset), "unknown form 'formatone'; known: format1, qmt"),
    ):
        done = here("export", *words, "--out", tmp_path / "none")
        assert done.code == 2 and said in done.err
        assert not (tmp_path / "none").exists()


@pytest.mark.parametrize(("kept", "groups"), [("core", {"hinge_angle", "quaternion1", "quaternion2"}), ("none", None)])
def test_of_less_truth_there_is_less_reference(kept, groups, tmp_path):
    text = f"truth = '{kept}'\n" + SPEC.partition('[[rig]]\nfamily = "pendulum"')[0]
    reference = read(f"{made(tmp_path / 'd', text, 1)}#0")[1]
    if groups is None:
        assert reference is None
    else:
        assert {k for k, v in vars(reference).items() if v is not None} == groups | {"time"}


def test_at_a_url_too(dataset):
    for source in (f"file://{dataset}#2", Path(f"file://{dataset}#2")):  # `Path` takes a slash
        same(read(source)[0], read(f"{dataset}#2")[0])
        assert folder_of(source) is None
        assert label(source) == f"{dataset.name}-2"


def test_a_folder_of_that_very_name_comes_first(dataset, tmp_path):
    done = here("export", "format1", f"{dataset}#3", "--out", tmp_path / "one")
    assert done.code == 0
    shutil.move(tmp_path / "one" / "dataset-0000003", tmp_path / "d#4")
    assert read(tmp_path / "d#4")[0].name == "dataset-0000003"
    assert in_dataset(tmp_path / "d#4") is None and label(tmp_path / "d#4") == "d#4"


@pytest.mark.parametrize(
    ("source", "said"),
    [
        ("{d}#10", "expected a recording from 0 to 9, got 10"),
        ("{d}#x", "expected a folder with recording.toml, got nothing of that name"),
        ("{d}#", "expected a folder with recording.toml, got nothing of that name"),
        ("{d}/none#1", "expected a finished dataset, got no manifest.json"),
        ("{d}#99999999999", "expected a folder with recording.toml, got nothing of that name"),
    ],
)
def test_a_recording_that_is_not_there_is_one_line(dataset, source, said):
    done = here("estimate", "seel2012", source.format(d=dataset), "--out", dataset.parent / "never")
    assert done.code == 2
    assert said in done.err and done.err.count("\n") == 1
    assert not (dataset.parent / "never").exists()


def test_output_is_apart_from_the_dataset_it_reads(dataset):
    for out in (dataset, dataset / "samples" / "x", dataset.parent):
        with pytest.raises(InputError, match=r"expected a place for the output apart from the input .*d#2"):
            check_apart(out, [Path(f"{dataset}#2")])
    check_apart(dataset.parent / "beside", [f"{dataset}#2", "s3://bucket/d#2"])
    before = sorted(path.name for path in dataset.rglob("*"))
    for words in (("estimate", "seel2012"), ("diagnose",)):
        done = here(*words, f"{dataset}#2", "--out", dataset / "out")
        assert done.code == 2 and "apart from the input" in done.err
    assert sorted(path.name for path in dataset.rglob("*")) == before


def test_estimate_takes_it_and_judges_by_its_truth(tmp_path):
    text = 'seconds = 10\nrecordings_per_rig = 1\n[[rig]]\nfamily = "hinge"\n'
    dataset = made(tmp_path / "d", text, 2)
    done = here("estimate", "olsson2020", f"{dataset}#1", "--out", tmp_path / "out")
    assert done.code == 0 and "beside the reference" in done.out
    written = json.loads((tmp_path / "out" / "estimate.json").read_text())
    assert written["recording"] == "dataset-0000001"
    figures = written["beside_reference"]
    # Two MTw of 0.005 rad/s of bias on motions of 1 rad/s: the axis is right to some hundredths of a rad.
    assert max(figure["value"] for figure in figures.values()) < 0.1


@pytest.mark.long
def test_a_concealed_effect_is_found_by_diagnose_of_a_number(tmp_path):
    text = """
seconds = 10
recordings_per_rig = 1
[[rig]]
family = "pendulum"
[[effect]]
name = "gyro_bias"
at = "imu1"
bias = [0.05, 0.08]
"""
    dataset = made(tmp_path / "d", text, 4, seed=0)
    assert [e["effect"] for e in read_stored(dataset, 3).effects] == ["gyro_bias"]
    done = here("diagnose", f"{dataset}#3", "--out", tmp_path / "out")
    assert done.code == 0
    told = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert told["recording"] == "dataset-0000003"
    assert ("gyro_bias", "imu1") in [(f["effect"], f["at"]) for f in told["findings"]]
    assert f"{dataset}#3" in (tmp_path / "out" / "report.html").read_text()  # what to type next

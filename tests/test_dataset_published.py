"""README.md, croissant.json and the Parquet files say the same of a dataset, and others take it at their word."""

import json
import subprocess
import sys
from pathlib import Path

import mlcroissant
import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml

from imubench.dataset import columns, parse_spec, read, rows
from imubench.dataset.card import LIMITS
from imubench.dataset.drawing import first_rigs, split_of
from imubench.dataset.generate import generate
from imubench.dataset.manifest import MANIFEST, verify
from imubench.dataset.published.columns import TOLD, told
from imubench.dataset.published.croissant import CROISSANT
from imubench.dataset.published.notes import before_publishing, empty_splits
from imubench.dataset.published.readme import README
from imubench.dataset.published.terms import parse_terms
from imubench.dataset.shard import Job
from imubench.errors import InputError
from tests.command import here
from tests.hub import offline

SPEC = """
name = "made | for <all>"
summary = "hinges, limbs"
licence = "cc-by-4.0"
published = 2030-01-31
version = "2.1.0"
creator = "A. Maker"
url = "https://example.org/made"
seconds = [2, 3]
recordings_per_rig = 1
recordings_per_file = 4
splits = { train = 0.6, dev = 0.3, rare = 0.1, never = 0.0 }
[encoder]
[[pose]]
[[rig]]
family = "hinge"
soft_probability = 0.5
[[rig]]
family = "pendulum"
[[effect]]
name = "gyro_bias"
probability = 0.5
"""
COUNT = 7
PLAIN = "recordings_per_rig = 10\n[[rig]]\nfamily = 'free'\n"

__all__ = ["offline"]


def job(text: str, count: int = COUNT, out: Path | str = "d", seed: int = 4) -> Job:
    return Job({"spec.toml": text.encode()}, seed, count, str(out))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("published") / "d"
    generate(job(SPEC, out=out), workers=0)
    return out


@pytest.fixture(scope="module")
def counts(folder):
    return json.loads((folder / MANIFEST).read_text())["recordings"]


def head(folder: Path) -> dict:
    _, text, _ = (folder / README).read_text().split("---\n", 2)
    return yaml.safe_load(text)


def test_load_dataset_gives_the_splits(folder, counts, offline):
    there = {split: count for split, count in counts.items() if count}
    assert 2 <= len(there) < len(counts)  # "never" at least is empty, and loads all the same
    recordings = offline.load_dataset(str(folder), "recordings")
    assert {split: part.num_rows for split, part in recordings.items()} == there
    samples = offline.load_dataset(str(folder))
    for split, part in samples.items():
        assert set(part["split"]) == {split}
        assert set(part["recording"]) == set(recordings[split]["recording"])
        assert part.num_rows == sum(recordings[split]["samples"])
    index = recordings["train"]["recording"][0]
    mine = samples["train"].filter(lambda row: row["recording"] == index and row["imu1_time"] is not None)
    assert np.array_equal(mine["imu1_acc_z"], read(folder, index).recording.imu("imu1").accel[:, 2])


def test_the_features_that_readme_promises_are_those_of_the_files(folder, offline):
    for table in ("samples", "recordings"):
        promised = offline.load_dataset_builder(str(folder), table).info.features
        files = [str(file) for file in sorted((folder / table).iterdir())]
        assert promised == offline.load_dataset("parquet", data_files=files)["train"].features


def test_the_head_of_readme_names_licence_and_splits(folder, counts):
    found = head(folder)
    assert found["license"] == "cc-by-4.0" and found["pretty_name"] == "made | for <all>"
    assert found["size_categories"] == ["1K<n<10K"]  # 7 recordings of 2 to 3 s at 100 Hz
    for config in found["configs"]:
        assert [part["split"] for part in config["data_files"]] == [split for split, n in counts.items() if n]
        for part in config["data_files"]:
            assert list(folder.glob(part["path"]))


def test_readme_tells_every_column_with_its_unit(folder):
    text = (folder / README).read_text()
    for table in ("samples", "recordings"):
        for field in pq.read_schema(next((folder / table).iterdir())):
            kept = field.metadata
            said = told(field.name)
            assert (kept[b"unit"].decode(), kept[b"description"].decode()) == (said.unit, said.meaning)
            assert f"| {said.unit} | {said.meaning} |" in text
    assert "# made \\| for \\<all\\>" in text
    assert all(limit in text.replace("\\", "") for limit in LIMITS)


def test_every_column_that_a_spec_can_have_is_told_and_no_other():
    spec = parse_spec({"spec.toml": (SPEC + "[[pose]]\nsegment = 'segment2'\n").encode()})
    names = [*columns.schema(spec).names, *rows.schema(spec).names]
    assert {id(told(name)) for name in names} == {id(entry) for entry in TOLD.values()}


def test_croissant_is_valid_without_a_warning(folder):
    dataset = mlcroissant.Dataset(folder / CROISSANT)
    issues = dataset.metadata.ctx.issues
    assert not issues.errors and not issues.warnings, issues.report()
    assert dataset.metadata.ctx.conforms_to.value == "http://mlcommons.org/croissant/1.1"
    assert str(dataset.metadata.version) == "2.1.0" and "A. Maker" in dataset.metadata.cite_as


@pytest.mark.long
def test_its_own_command_says_so_too(folder):
    command = [Path(sys.executable).with_name("mlcroissant"), "validate", "--jsonld", folder / CROISSANT]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0
    assert [line[0] for line in done.stderr.splitlines()] == ["I"]  # one line of information: Done


def test_croissant_reads_every_record_as_it_is(folder, counts):
    dataset = mlcroissant.Dataset(folder / CROISSANT)
    assert [r["splits/name"] for r in dataset.records("splits")] == [split for split, n in counts.items() if n]
    found = {record["recordings/recording"]: record for record in dataset.records("recordings")}
    assert sorted(found) == list(range(COUNT))
    for index, record in found.items():
        row = read(folder, index).row
        for key, value in row.items():
            got = record.get(f"recordings/{key}")
            if key == "effects":
                told_of = [{k.rpartition("/")[2]: v.decode() for k, v in e.items()} for e in got or []]
                assert [e for e in told_of if e["effect"]] == value
            elif isinstance(value, str):
                assert got.decode() == value
            elif value is not None:
                assert np.array_equal(got, value), key
    sample = next(iter(dataset.records("samples")))
    stored = read(folder, int(sample["samples/recording"]))
    assert sample["samples/imu1_gyr_x"] == np.float32(stored.recording.imu("imu1").gyro[0, 0])


def test_manifest_counts_the_rows_and_covers_the_new_files(folder, tmp_path):
    table = verify(str(folder))
    for name, entry in table["files"].items():
        if name.endswith(".parquet"):
            assert pq.read_metadata(folder / name).num_rows == entry["rows"]
    for name in (README, CROISSANT):
        before = (folder / name).read_text()
        try:
            (folder / name).write_text(before.replace("2.1.0", "2.1.1"))
            with pytest.raises(InputError, match=rf"{name} \(changed\)"):
                verify(str(folder))
        finally:
            (folder / name).write_text(before)


@pytest.mark.parametrize("seed", range(3))
def test_a_split_that_will_be_empty_is_foretold_with_the_least_count_that_fills_it(seed):
    for count in (10, 40, 200):
        asked = job(PLAIN, count, seed=seed)
        rigs = -(-count // 10)
        there = {split_of(asked.spec, seed, rig) for rig in range(rigs)}
        warned = empty_splits(asked)
        assert len(warned) == 3 - len(there)
        for line in warned:
            split, least = line.split("'")[1], int(line.split("--count ")[1].split()[0])
            assert split not in there
            assert least > count
            for more, filled in ((least - 1, False), (least, True)):
                others = {split_of(asked.spec, seed, rig) for rig in range(-(-more // 10))}
                assert (split in others) is filled


def test_of_the_smallest_fraction_it_is_said_that_it_is_too_small():
    spec = job("splits = { train = 0.99999999, rest = 0.00000001 }\n" + PLAIN)
    assert set(first_rigs(spec.spec, 4)) == {"train"}
    assert "its fraction is too small" in empty_splits(spec)[0]


def test_generate_warns_before_the_work_and_says_what_is_missing_for_publication(tmp_path):
    (tmp_path / "s.toml").write_text("seconds = 1\n" + PLAIN)
    done = here("generate", tmp_path / "s.toml", "--count", "1", "--workers", "0", "--out", tmp_path / "d")
    lines = done.out.splitlines()
    assert done.code == 0 and done.err == ""
    assert [line.split("'")[1] for line in lines if line.startswith("warning: split")] == ["train", "test"]
    assert lines[0].startswith("warning") and 'licence = "CC-BY-4.0", published = 2030-01-31' in lines[-1]
    issues = mlcroissant.Dataset(tmp_path / "d" / CROISSANT).metadata.ctx.issues
    assert not issues.errors
    assert {text.split('"')[1].rpartition("/")[2] for text in issues.warnings} == {"license", "datePublished"}
    assert head(tmp_path / "d")["license"] == "unknown"


def test_nothing_is_missing_where_a_spec_says_it():
    assert before_publishing(job(SPEC)) == ""


def test_a_licence_that_no_list_has_is_kept_as_it_is(tmp_path):
    text = SPEC.replace("cc-by-4.0", "for our own use: ask").replace("COUNT", "1")
    generate(job(text, 1, tmp_path / "d"), workers=0)
    found = head(tmp_path / "d")
    assert (found["license"], found["license_name"]) == ("other", "for our own use: ask")
    assert json.loads((tmp_path / "d" / CROISSANT).read_text())["license"] == "for our own use: ask"


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"version": "1"}, "version: expected one such as 1.0.0"),
        ({"version": 1.0}, "version: expected a line of text, got 1.0"),
        ({"published": "2030-01-31"}, "published: expected a date such as 2030-01-31, without quotes"),
        ({"url": "example.org"}, "url: expected one that begins with https://"),
        ({"licence": "a\nb"}, "licence: expected a line of text"),
    ],
)
def test_terms_that_are_none_are_one_line(table, said):
    with pytest.raises(InputError, match=said):
        parse_terms(table, "s.toml")


@pytest.mark.parametrize("name", ["all", "a b", "../x", "train-1", "", "é"])
def test_a_split_is_named_so_that_files_and_readers_take_it(name):
    with pytest.raises(InputError, match="expected names of letters, digits and _, and not 'all'"):
        parse_spec({"spec.toml": f"splits = {{ train = 0.5, {json.dumps(name)} = 0.5 }}\n{PLAIN}".encode()})


def test_splits_that_differ_in_case_alone_are_refused():
    with pytest.raises(InputError, match="expected names that differ in more than case, got train, Train"):
        parse_spec({"spec.toml": f"splits = {{ train = 0.5, Train = 0.5 }}\n{PLAIN}".encode()})

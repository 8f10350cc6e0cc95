"""What is written is read back: by one call as a Recording and its Truth, and by other readers as plain tables."""

import json
from dataclasses import fields

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow.parquet as pq
import pytest

from imubench.dataset import make, parse_spec, read
from imubench.dataset.generate import generate
from imubench.dataset.shard import Job
from imubench.errors import InputError
from imubench.recording import Imu

SPEC = """
seconds = [3, 5]
recordings_per_rig = 2
recordings_per_file = 4
precision = "double"
[[rig]]
family = "hinge"
[[rig]]
family = "pendulum"
[[rig]]
family = "hinge"
base = "fixed"
[[imu]]
profile = "mpu9250"
[[imu]]
profile = "xsens_mtw"
[[effect]]
name = "dropouts"
probability = 0.5
fraction = 0.1
[[effect]]
name = "clock_skew"
probability = 0.3
[[effect]]
name = "time_offset"
probability = 0.3
"""
COUNT, SEED = 14, 5


@pytest.fixture(scope="module")
def spec():
    return parse_spec({"spec.toml": SPEC.encode()})


@pytest.fixture(scope="module")
def folder(tmp_path_factory, spec):
    out = tmp_path_factory.mktemp("datasets") / "small"
    generate(Job(spec.content, SEED, COUNT, str(out)), workers=0)
    return out


@pytest.mark.parametrize("index", range(COUNT))
def test_a_recording_comes_back_as_it_was_made(folder, spec, index):
    made, stored = make(spec, SEED, index), read(folder, index)
    assert stored.recording.name == made.recording.name
    assert (stored.recording.rig, stored.recording.base) == (made.recording.rig, made.recording.base)
    assert np.array_equal(stored.recording.base_quaternion, made.recording.base_quaternion)
    for got, was in zip(stored.recording.imus, made.recording.imus, strict=True):
        for field in fields(Imu):
            assert np.array_equal(getattr(got, field.name), getattr(was, field.name)), field.name
    assert [(e["effect"], e["at"]) for e in stored.effects] == [(e["effect"], e["at"]) for e in made.drawn.effects]


@pytest.mark.parametrize("index", (0, 3, 7))
def test_the_truth_comes_back_as_it_was(folder, spec, index):
    was, got = make(spec, SEED, index).truth, read(folder, index).truth
    pairs = [(was, got), *zip(was.segments, got.segments, strict=True), *zip(was.sensors, got.sensors, strict=True)]
    for a, b in pairs:
        for field in fields(a):
            one, other = getattr(a, field.name), getattr(b, field.name)
            if isinstance(one, np.ndarray):
                assert np.array_equal(one, other), field.name
            elif not isinstance(one, tuple):
                assert one == other, field.name


def test_single_precision_rounds_and_does_nothing_else(tmp_path):
    content = {"spec.toml": SPEC.replace("double", "single").encode()}
    generate(Job(content, SEED, 2, str(tmp_path / "d")), workers=0)
    made, stored = make(parse_spec(content), SEED, 1), read(tmp_path / "d", 1)
    for got, was in zip(stored.recording.imus, made.recording.imus, strict=True):
        assert np.array_equal(got.accel, was.accel.astype(np.float32))
        assert np.array_equal(got.time, was.time)


@pytest.mark.parametrize(("kept", "columns"), [("core", 59), ("none", 17)])
def test_less_truth_on_wish(tmp_path, kept, columns):
    text = f"truth = '{kept}'\n" + SPEC
    generate(Job({"spec.toml": text.encode()}, SEED, 1, str(tmp_path / "d")), workers=0)
    (file,) = (tmp_path / "d/samples").iterdir()
    assert len(pq.read_schema(file).names) == columns
    assert read(tmp_path / "d", 0).truth is None


def test_samples_stand_in_the_row_nearest_to_their_stamp(folder):
    table = pd.read_parquet(folder / "samples")
    for name in ("imu1", "imu2"):
        off = (table[f"{name}_time"] - table["time"]).dropna().abs()
        drift = 0.01 * 5 / 2  # s: what a skew of three priors' stds makes in 5 s, far below half a period otherwise
        assert off.max() <= 0.5 / 100 + drift
        assert off.size > 0.8 * len(table) * (1 if name == "imu1" else 0.5)


def test_pandas_reads_both_tables(folder):
    samples, recordings = pd.read_parquet(folder / "samples"), pd.read_parquet(folder / "recordings")
    assert sorted(recordings["recording"]) == list(range(COUNT))
    counts = samples.groupby("recording").size()
    assert counts.to_dict() == dict(zip(recordings["recording"], recordings["samples"], strict=True))
    assert recordings.groupby("rig")["split"].nunique().max() == 1
    row = recordings.set_index("recording").loc[3]
    assert row["imu1_position"].shape == (3,)
    assert all(set(json.loads(e["parameters"])) for e in row["effects"])
    one = samples[samples["recording"] == 3].dropna(subset=["imu1_time"])
    assert np.array_equal(one["imu1_gyr_x"], read(folder, 3).recording.imu("imu1").gyro[:, 0])


def test_polars_reads_both_tables(folder):
    assert pl.read_parquet(folder / "recordings/*.parquet").height == COUNT
    assert pl.scan_parquet(folder / "samples/*.parquet").select(pl.col("time").max()).collect().item() < 5


def test_duckdb_reads_both_tables(folder):
    tables = (f"'{folder}/{kind}/*.parquet'" for kind in ("samples", "recordings"))
    sql = f"select count(distinct recording) from {' join '.join(tables)} using (recording)"
    assert duckdb.sql(sql).fetchall() == [(COUNT,)]


def test_the_sums_of_all_readers_agree(folder):
    """Each reads the same numbers, not only as many rows."""
    column = "imu1_gyr_x"
    table = pq.read_table(folder / "samples", columns=["recording", column])
    sums = table.group_by("recording").aggregate([(column, "sum")]).to_pydict()
    wanted = dict(zip(sums["recording"], sums[f"{column}_sum"], strict=True))
    by_pandas = pd.read_parquet(folder / "samples").groupby("recording")[column].sum().to_dict()
    scanned = pl.scan_parquet(folder / "samples/*.parquet").group_by("recording").agg(pl.col(column).sum()).collect()
    sql = f"select recording, sum({column}) from '{folder}/samples/*.parquet' group by recording"
    for got in (by_pandas, dict(scanned.iter_rows()), dict(duckdb.sql(sql).fetchall())):
        # The same doubles in another order: 500 sums of numbers below 10 are off by 500 * 10 * 1e-16 at most.
        assert got == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("index", (-1, COUNT))
def test_a_number_that_is_not_there(folder, index):
    with pytest.raises(InputError, match=f"expected a recording from 0 to {COUNT - 1}, got {index}"):
        read(folder, index)


def test_a_folder_that_is_no_dataset(tmp_path):
    with pytest.raises(InputError, match=r"expected a finished dataset, got no manifest.json"):
        read(tmp_path, 0)

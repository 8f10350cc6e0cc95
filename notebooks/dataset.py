"""A dataset made, read, and scored on its test split. `marimo edit notebooks/dataset.py`."""

import marimo

app = marimo.App()


@app.cell
def _():
    import tempfile
    from pathlib import Path

    import marimo as mo
    import numpy as np
    import pandas as pd

    import imubench as ib
    from imubench.dataset import read
    from imubench.dataset.generate import generate
    from imubench.dataset.reading import indices
    from imubench.dataset.shard import Job

    return Job, Path, generate, ib, indices, mo, np, pd, read, tempfile


@app.cell
def _(mo):
    mo.md("""
    # A dataset, from a spec to a score

    Rigs, motions, IMUs and what they get wrong are drawn from a few lines of TOML; everything follows from them, a seed
    and a number. `imubench generate` does the same on all cores, and on a cluster.
    """)
    return


@app.cell
def _(Job, Path, generate, tempfile):
    spec = """
    name = "hinges"
    seconds = 10
    recordings_per_rig = 2
    splits = { train = 0.75, test = 0.25 }
    [[rig]]
    family = "hinge"
    [[motion]]
    kind = "olsson2020"
    numbers = [3, 11, 14]
    [[effect]]
    name = "gyro_bias"
    probability = 0.5
    bias = { std = 0.05 }
    """
    folder = Path(tempfile.mkdtemp()) / "hinges"
    manifest = generate(Job({"spec.toml": spec.encode()}, seed=0, count=16, out=str(folder)), workers=0)
    manifest["recordings"]
    return (folder,)


@app.cell
def _(mo):
    mo.md("""
    One table says what was drawn for each recording, another has the samples; both are Parquet files, which any reader
    takes: pandas, polars, DuckDB, or `datasets.load_dataset(DIR)`, split by split.
    """)
    return


@app.cell
def _(folder, pd):
    recordings = pd.read_parquet(folder / "recordings").set_index("recording").sort_index()
    recordings[["split", "rig", "motion", "imu1_gyro_bias"]]
    return (recordings,)


@app.cell
def _(folder, ib):
    ib.load(f"{folder}#3")
    return


@app.cell
def _(folder, ib, indices, np, pd, read):
    rows = []
    for index in indices(folder, "test"):
        stored = read(folder, index)
        for name in ("olsson2020", "seel2012"):
            judged = ib.score(ib.estimate(name, stored.recording), stored.truth)
            off = np.degrees(max(judged.deviation(imu.name) for imu in stored.recording.imus))
            rows.append((index, stored.row["motion"], name, off))
    errors = pd.DataFrame(rows, columns=["recording", "motion", "estimator", "error, deg"])
    errors.round(2)
    return (errors,)


@app.cell
def _(errors):
    errors.groupby("estimator")["error, deg"].describe().round(2)
    return


if __name__ == "__main__":
    app.run()

"""A recording with something concealed in it: found, and judged by its truth. `marimo edit notebooks/diagnosis.py`."""

import marimo

app = marimo.App()


@app.cell
def _():
    import tempfile
    from pathlib import Path

    import marimo as mo

    import imubench as ib
    from imubench.dataset import read
    from imubench.dataset.generate import generate
    from imubench.dataset.shard import Job

    return Job, Path, generate, ib, mo, read, tempfile


@app.cell
def _(mo):
    mo.md("""
    # What does my model leave out?

    A spec draws recordings of a limb on a ball joint whose gyroscope is off by a constant. The recording does not say
    so; the dataset does, and we look there at the end.
    """)
    return


@app.cell
def _(Job, Path, generate, tempfile):
    spec = """
    seconds = 10
    recordings_per_rig = 1
    [[rig]]
    family = "pendulum"
    [[effect]]
    name = "gyro_bias"
    at = "imu1"
    bias = [0.05, 0.08]  # rad/s
    """
    folder = Path(tempfile.mkdtemp()) / "concealed"
    generate(Job({"spec.toml": spec.encode()}, seed=0, count=4, out=str(folder)), workers=0)
    source = f"{folder}#3"
    return folder, source


@app.cell
def _(ib, source):
    recording, reference = ib.load(source), ib.load_reference(source)
    recording
    return recording, reference


@app.cell
def _(ib, recording, reference):
    diagnosis = ib.diagnose(recording, reference, time_limit=120)
    diagnosis
    return (diagnosis,)


@app.cell
def _(diagnosis):
    diagnosis.plot()
    return


@app.cell
def _(diagnosis):
    diagnosis.to_pandas()
    return


@app.cell
def _(mo):
    mo.md("""
    Now the truth:
    """)
    return


@app.cell
def _(folder, read):
    concealed = read(folder, 3).effects
    concealed
    return (concealed,)


@app.cell
def _(concealed, diagnosis):
    found = {(finding.effect, finding.at) for finding in diagnosis.findings}
    missed = [effect for effect in concealed if (effect["effect"], effect["at"]) not in found]
    missed
    return (missed,)


if __name__ == "__main__":
    app.run()

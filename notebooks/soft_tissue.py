"""How wrong an estimate is on a mount that gives way, over its frequency. `marimo edit notebooks/soft_tissue.py`."""

import marimo

app = marimo.App()


@app.cell
def _():
    import tempfile
    from pathlib import Path

    import marimo as mo
    import pandas as pd

    import imubench as ib

    return Path, ib, mo, pd, tempfile


@app.cell
def _(mo):
    mo.md("""
    # Soft tissue under a sensor

    An IMU on skin or foam rocks on a spring and a damper. Here both IMUs of a hinge do, from 4 Hz, which is soft, to
    25 Hz, which is stiff. MuJoCo plays each rig under the same motion. The spec is that of `imubench sweep`: put the
    numbers of your own rig in.
    """)
    return


@app.cell
def _():
    spec = """
    name = "soft-tissue"
    seconds = 10
    recordings = 4                        # in each cell
    limit_deg = 3

    [[rig]]
    family = "hinge"
    segment_length = 0.3                  # m
    mount_distance = 0.12                 # m from the joint

    [[effect]]
    name = "rocking_mount"
    damping_ratio = 0.2
    com = [-0.004, 0.004]                 # m, off the pivot

    [[axis]]
    parameter = "effect.rocking_mount.frequency"
    values = [4, 7, 12, 25]               # Hz
    scale = "log"
    """
    return (spec,)


@app.cell
def _(Path, ib, spec, tempfile):
    folder = Path(tempfile.mkdtemp())
    (folder / "sweep.toml").write_text(spec)
    cells = ib.sweep(folder / "sweep.toml", ["olsson2020", "seel2012"], folder / "out", workers=0)
    len(cells)
    return cells, folder


@app.cell
def _(cells, folder, pd):
    assert cells  # the table is written with them
    errors = pd.read_csv(folder / "out" / "sweep.csv")
    table = errors.pivot_table(index="effect.rocking_mount.frequency", columns="estimator", values="value")
    table.round(2)  # median error of the axis, deg
    return errors, table


@app.cell
def _(errors):
    errors[["estimator", "effect.rocking_mount.frequency", "value", "value_low", "value_high", "played", "failed"]]
    return


@app.cell
def _(table):
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6, 3), layout="constrained")
    panel = figure.subplots()
    for column in table:
        panel.loglog(table.index, table[column], "o-", label=column)
    panel.set(xlabel="frequency of the mounts, Hz", ylabel="error of the axis, deg")
    panel.legend(frameon=False)
    figure
    return


if __name__ == "__main__":
    app.run()

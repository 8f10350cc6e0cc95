"""How wrong an estimate is on a mount that gives way, over its frequency. `marimo edit notebooks/soft_tissue.py`."""

import marimo

app = marimo.App()


@app.cell
def _():
    from dataclasses import replace

    import marimo as mo
    import numpy as np
    import pandas as pd

    import imubench as ib
    from imubench.scenarios.hinge import hand_motion
    from imubench.sim.play import play
    from imubench.sim.rigs import random_hinge, springs

    return hand_motion, ib, mo, np, pd, play, random_hinge, replace, springs


@app.cell
def _(mo):
    mo.md("""
    # Soft tissue under a sensor

    An IMU on skin or foam rocks on a spring and a damper. Here both IMUs of a hinge do, from 4 Hz, which is soft, to
    25 Hz, which is stiff. MuJoCo plays each rig under the same motion.
    """)
    return


@app.cell
def _(hand_motion, np, play, random_hinge, replace, springs):
    def played(frequency, seed=0, seconds=15.0):
        """Return the truth of a hinge whose IMUs rock at a frequency in Hz, damped by a fifth."""
        rng = np.random.default_rng(seed)
        rig = random_hinge(rng)
        mounts = tuple(replace(mount, rotation=springs(frequency, 0.2)) for mount in rig.mounts)
        return play(replace(rig, mounts=mounts), hand_motion(rng), seconds)

    return (played,)


@app.cell
def _(ib, played):
    truth = played(6.0)
    recording = ib.observe(truth, "xsens_mtw", seed=1)
    recording
    return


@app.cell
def _(ib, np, pd, played):
    rows = []
    for frequency in (4.0, 7.0, 12.0, 25.0):
        for seed in range(2):
            soft = played(frequency, seed)
            observed = ib.observe(soft, "xsens_mtw", seed)
            for name in ("olsson2020", "seel2012"):
                judged = ib.score(ib.estimate(name, observed), soft)
                off = np.degrees(max(judged.deviation(imu.name) for imu in observed.imus))
                rows.append((frequency, seed, name, off))
    errors = pd.DataFrame(rows, columns=["frequency, Hz", "seed", "estimator", "error, deg"])
    table = errors.pivot_table(index="frequency, Hz", columns="estimator", values="error, deg", aggfunc="max")
    table.round(2)
    return (table,)


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

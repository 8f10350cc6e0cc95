"""An estimator of one's own, beside ours, on rigs and IMUs that are drawn. `marimo edit notebooks/estimator.py`."""

import marimo

app = marimo.App()


@app.cell
def _():
    import marimo as mo
    import numpy as np
    import pandas as pd

    import imubench as ib

    return ib, mo, np, pd


@app.cell
def _(mo):
    mo.md("""
    # Judge an estimator of your own

    Two segments on a hinge, an IMU on each. Where is the hinge axis, in the axes of each IMU? A scenario is played and
    observed; the estimator sees the recording alone, and the truth judges it.
    """)
    return


@app.cell
def _(ib):
    recording, truth = ib.simulate("hinge-planar", seed=1)
    recording
    return recording, truth


@app.cell
def _(mo):
    mo.md("""
    A first idea: here the axis stays where it is, and each IMU turns about it and nothing else. So take the direction
    in which its angular rate varies most.
    """)
    return


@app.cell
def _(ib, np):
    def principal_rate(recording):
        """Return the direction of most angular rate of each IMU; how the signs pair it cannot tell."""
        axes = [np.linalg.svd(imu.gyro, full_matrices=False)[2][0] for imu in recording.imus]
        return ib.Estimate("joint_axis", "principal-rate", np.stack(axes), None, "not worked out", pairing="unknown")

    return (principal_rate,)


@app.cell
def _(ib, principal_rate, recording, truth):
    ib.score(principal_rate(recording), truth)
    return


@app.cell
def _(mo):
    mo.md("""
    Right where the axis rests, and wrong where a hand moves it about. One run says little: here are both kinds of
    motion, other seeds and other IMUs, each beside Olsson et al. 2020.
    """)
    return


@app.cell
def _(ib, np, pd, principal_rate):
    rows = []
    for scenario in ("hinge-planar", "hinge-hand"):
        for seed in range(3):
            played = ib.simulate(scenario, seed)[1]
            for profile in ("xsens_mtw", "mpu9250"):
                observed = ib.observe(played, profile, seed)
                for answer in (principal_rate(observed), ib.estimate("olsson2020", observed)):
                    off = np.degrees(max(ib.score(answer, played).deviation(imu.name) for imu in observed.imus))
                    rows.append((scenario, profile, answer.estimator, off))
    errors = pd.DataFrame(rows, columns=["scenario", "IMU", "estimator", "error, deg"])
    table = errors.pivot_table(index=["scenario", "IMU"], columns="estimator", values="error, deg", aggfunc="max")
    table.round(2)
    return (table,)


@app.cell
def _(table):
    worst = table["principal-rate"].groupby("scenario").max()
    worst
    return


if __name__ == "__main__":
    app.run()

"""Figure 2: the shape of the cost function as the gyroscope's weight grows."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.olsson2020.measures_weights import GYRO_WEIGHTS, surface, wrong_minima
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing


def exhibit(r: Results) -> Figure:
    """Return figure 2."""
    appears = next((w for w in GYRO_WEIGHTS if wrong_minima(r, w)), None)
    finding = (
        "No weight of the gyroscope makes the wrong sign pairing a minimum"
        if appears is None
        else f"With a gyroscope weight of {appears:g} the wrong sign pairing has become a minimum too"
    )
    text = (
        "The cost V(x) of motion 6 (both segments turn in a plane) over the direction of the axis in "
        "sensor 2, with the axis in sensor 1 held at the truth and w_a = 1. Each panel has its own scale, from its "
        "smallest value to its largest. Circle: the right sign pairing. Cross: the wrong one, at phi + 180 deg."
    )
    return Figure("figure2", "Figure 2", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw surfaces above, their contours below."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 5.6), layout="constrained")
    theta, phi = np.rad2deg(r.surface["theta"]), np.rad2deg(r.surface["phi"])
    for k, weight in enumerate(GYRO_WEIGHTS):
        cost = surface(r, weight)
        height = (cost - cost.min()) / (cost.max() - cost.min())
        solid = figure.add_subplot(2, len(GYRO_WEIGHTS), k + 1, projection="3d")
        solid.plot_surface(*np.meshgrid(phi, theta), height, cmap="viridis", rcount=60, ccount=90, linewidth=0)
        solid.set_title(f"$w_\\omega$ = {weight:g}", fontsize=11)
        solid.view_init(elev=35, azim=-60)
        solid.set_xticks([-90, 0, 90, 180, 270])
        solid.set_yticks([-90, 0, 90])
        solid.set_zticks([])
        solid.set_xlabel("$\\phi_2$", labelpad=-4)
        solid.set_ylabel("$\\theta_2$", labelpad=-4)
        solid.tick_params(labelsize=7, pad=-2)
        flat = figure.add_subplot(2, len(GYRO_WEIGHTS), len(GYRO_WEIGHTS) + k + 1)
        drawn = flat.contourf(phi, theta, height, levels=24, cmap="viridis")
        flat.plot(90, 0, "o", color="white", ms=8, mfc="none", mew=2)
        flat.plot(270, 0, "x", color="white", ms=8, mew=2, clip_on=False)
        flat.plot(-90, 0, "x", color="white", ms=8, mew=2, clip_on=False)
        flat.set_xticks([-90, 0, 90, 180, 270])
        flat.set_yticks([-90, 0, 90])
        flat.set_xlabel("$\\phi_2$, deg")
        if k == 0:
            flat.set_ylabel("$\\theta_2$, deg")
    bar = figure.colorbar(drawn, ax=figure.axes[1::2], ticks=[0, 1], pad=0.01)
    bar.ax.set_yticklabels(["lowest", "highest"])
    bar.set_label("V(x) of the panel")
    return figure

"""Figure 6: the errors over time, with all samples and with selected ones."""

from typing import TYPE_CHECKING

import numpy as np

from imubench.reproduce.olsson2020.measures_time import apart_from_all, settled
from imubench.reproduce.olsson2020.results import Results
from imubench.reproduce.olsson2020.settings import SEQUENCES, SIZES
from imubench.reproduce.olsson2020.style import SIZE_COLOURS, clipped, degrees_axis, mark_sections, size_name
from imubench.reproduce.paper import Figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Drawing


def exhibit(r: Results) -> Figure:
    """Return figure 6."""
    apart = max(apart_from_all(r, n).value for n in SIZES if n)
    end = max(float(np.rad2deg(r.over_time[n][size][-1]).max()) for n in SEQUENCES for size in SIZES)
    times = {n: settled(r, n, 1000, 3.0, (0, 1)) for n in SEQUENCES}
    listed = ", ".join(f"{t:.0f} s" for t in times.values())
    finding = (
        f"Once the joint has moved, selected samples do as well as all to {apart:.2g} deg; all end within {end:.2g} deg"
    )
    every = "second" if r.settings.every == 1 else f"{r.settings.every} s"
    text = (
        f"Errors of both axes; each {every} one new estimate from a random start, w0 = 50. The scale is "
        "logarithmic: the "
        "simulated rig is rigid, so errors fall far below the paper's 1.5 deg. Dashed lines and numbers: the "
        "motions. With "
        f"N_max = 1000 both errors stay under 3 deg from {listed} on in sequences 1 to 4. Above 90 deg: the "
        "wrong sign pairing."
    )
    return Figure("figure6", "Figure 6", finding, text, lambda: draw(r))


def draw(r: Results) -> "Drawing":
    """Draw a row for each sequence, a column for each axis."""
    from matplotlib.figure import Figure as Canvas

    figure = Canvas(figsize=(12, 10), layout="constrained")
    grid = figure.subplots(len(SEQUENCES), 2, sharey=True)
    for row, name, letter in zip(grid, SEQUENCES, "abcd", strict=True):
        for axes, i in zip(row, (0, 1), strict=True):
            for n_max, errors in r.over_time[name].items():
                label = size_name(n_max)
                axes.plot(r.times(name), clipped(errors[:, i]), color=SIZE_COLOURS[n_max], lw=0.9, label=label)
            degrees_axis(axes)
            axes.set_xlim(0, r.sections(name)[-1].end)
            mark_sections(axes, r.sections(name))
        row[0].set_ylabel(f"({letter}) sequence {name[-1]}\nerror, deg")
    for axes, i in zip(grid[0], (1, 2), strict=True):
        axes.set_title(f"axis in sensor {i}, $j_{i}$", pad=16)
    for axes in grid[-1]:
        axes.set_xlabel("time, s")
    grid[0, 1].legend(loc="upper right", frameon=False, fontsize=8, ncols=2)
    return figure

"""Sweeps: errors of estimators over a grid of one or two numbers of a rig, a motion, an IMU or an effect.

    from imubench.sweeps import load_sweep, sweep
    rows = sweep(load_sweep(Path("sweep.toml")), ["olsson2020", "mine.py:estimate"], Path("runs/mine"))

A sweep is a dataset's spec with `[[axis]]` tables (docs/your-tissue.md). Each cell of the grid has a spec of its own,
in which the axes' numbers stand; recording k of a cell is recording k of the dataset that `imubench generate` makes
of that spec. So recordings with the same number share rig, motion and noise over the whole grid.
"""

from imubench.sweeps.run import sweep
from imubench.sweeps.spec import Sweep, load_sweep

__all__ = ["Sweep", "load_sweep", "sweep"]

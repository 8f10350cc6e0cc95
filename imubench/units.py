"""Units in which people give and read lengths and angles, and what one of each is in SI."""

from collections.abc import Mapping

import numpy as np

DEG = np.pi / 180
LENGTH: Mapping[str, float] = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
ANGLE: Mapping[str, float] = {"rad": 1.0, "deg": DEG, "mrad": 1e-3}
UNITS: Mapping[str, Mapping[str, float]] = {"rad": ANGLE, "m": LENGTH}
"""What a figure of a score may be given in, by its SI unit; times so much it is that unit."""
SHOWN: Mapping[str, tuple[str, float]] = {"rad": ("deg", 1.0 / DEG), "m": ("mm", 1e3)}
"""The unit in which a figure is shown, and what it is multiplied by for that, by its SI unit."""

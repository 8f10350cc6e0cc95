"""The mass of a swinging limb, as recording.toml declares it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from imubench.proof.rotation import Array


@dataclass(frozen=True)
class Body:
    """Mass kg, com (3,) m and principal inertia (3,) kg m^2 about the com, segment axes. True but for `inertia`."""

    mass: float
    com: Array
    inertia: Array

    @property
    def about_pivot(self) -> Array:
        """The inertia (3, 3) about the segment's origin."""
        return np.diag(self.inertia) + self.mass * (self.com @ self.com * np.eye(3) - np.outer(self.com, self.com))

    @property
    def about_y(self) -> float:
        """The inertia about +y through the origin, the hinge axis."""
        return float(self.about_pivot[1, 1])

    def declared(self) -> dict[str, Any]:
        """Return the table [body]."""
        return {"mass": self.mass, "com": self.com, "inertia": self.inertia}


def limb(rng: np.random.Generator, axis: int) -> Body:
    """Return a limb or rod that extends from the joint along +x (axis 0: hinge) or -z (axis 2: pendulum)."""
    mass, length = rng.uniform(0.5, 3.0), rng.uniform(0.25, 0.5)
    across, along = rng.uniform(0.9, 1.2) * mass * length**2 / 12, mass * rng.uniform(0.02, 0.04) ** 2
    com = rng.uniform(-0.012, 0.012, 3)
    com[axis] = (1.0 if axis == 0 else -1.0) * rng.uniform(0.4, 0.55) * length
    inertia = across * rng.uniform(0.97, 1.03, 3)
    inertia[axis] = along
    return Body(float(mass), com, inertia)

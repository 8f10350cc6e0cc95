"""Which directions of an effect's numbers a recording fixes, and which it does not.

With S the covariance of k numbers after the recording and D the diagonal of their priors' standard deviations, the
eigenvectors of D^-1 S D^-1 are the directions in which recording and prior say most and least, and an eigenvalue is the
variance there over the prior's: 1 where the recording says nothing. A direction counts as not seen from
`OBSERVABILITY.hidden` of the prior's standard deviation on. Then 1 / s^2 = 1 / p^2 + 1 / d^2 with s = p / 2 gives d = p
/ sqrt(3) for what the data alone would say: less clear than that, and more than a fourth of the number is what was held
for plausible before.
"""

from dataclasses import dataclass

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import OBSERVABILITY
from imubench.errors import InputError


@dataclass(frozen=True)
class Directions:
    """Which directions of a parameter's k numbers a recording fixes, and how well."""

    covariance: Array  # (k, k) of the numbers, in their unit squared
    unseen: Array  # (k, m) unit vectors of the numbers' space, that the recording says little of; m may be 0
    from_none: bool = True  # whether zeros mean that there is no such thing: then a length says how large it is

    def __post_init__(self) -> None:
        for key in ("covariance", "unseen"):
            array = np.array(getattr(self, key), dtype=float)
            if array.ndim != 2 or not np.isfinite(array).all():
                raise InputError(f"parameter.{key}: expected a matrix of finite numbers, got shape {array.shape}")
            array.flags.writeable = False
            object.__setattr__(self, key, array)
        if self.covariance.shape != (len(self.unseen),) * 2:
            raise InputError(
                f"parameter.unseen: expected as many rows as a covariance of shape {self.covariance.shape}, "
                f"got {len(self.unseen)}"
            )


def directions(covariance: Array, prior: Array, from_none: bool = True) -> Directions:
    """Return which directions of k numbers are seen.

    Args:
        covariance: (k, k) after the recording, priors counted in.
        prior: (k,) standard deviations of the priors.
        from_none: whether zeros mean that there is no such thing.
    """
    k = len(prior)
    scaled = np.asarray(covariance / np.outer(prior, prior), dtype=float)
    values, vectors = np.linalg.eigh((scaled + scaled.T) / 2)
    hidden = vectors[:, values > OBSERVABILITY.hidden**2] * prior[:, None]
    unseen = np.linalg.qr(hidden)[0] if hidden.shape[1] else np.zeros((k, 0))
    return Directions(covariance, aligned(unseen), from_none)


def aligned(basis: Array) -> Array:
    """Return an orthonormal basis (k, m) of the same space that lies along axes where it can, each pointing upwards.

    A space of several directions has no directions of its own: those axes that lie in it are the ones to name.
    """
    left, out = basis, []
    while left.shape[1]:
        inside = np.sum(left**2, axis=1)  # of each axis, the square of its part in the space
        best = int(np.argmax(inside))
        vector = left @ left[best] / np.sqrt(inside[best])
        out.append(vector)
        rest = left - np.outer(vector, vector @ left)
        u, size, _ = np.linalg.svd(rest, full_matrices=False)
        left = u[:, size > 0.5]  # of an orthonormal basis one is 0 and the others are 1
    found = np.stack(out, axis=1) if out else basis
    largest = np.argmax(np.abs(found), axis=0)
    return found * np.where(found[largest, np.arange(found.shape[1])] < 0, -1.0, 1.0)


def in_words(name: str, unseen: Array, axes: dict[str, Array], frame: str) -> tuple[str, ...]:
    """Return unseen directions of a parameter as they stand in a sentence after "the".

    Args:
        name: of the parameter.
        unseen: (k, m) unit vectors.
        axes: name -> unit vector (k,) of directions that have a name: "along the hinge axis"; the first that is near.
        frame: in which the numbers are given, for a direction that has none: "segment axes".
    """
    called = name.replace("_", " ")
    k, m = unseen.shape
    if m == k:
        return (called,) if m else ()
    out = []
    for vector in unseen.T:
        near = next((text for text, axis in axes.items() if abs(float(vector @ axis)) > OBSERVABILITY.along_cosine), "")
        if near:
            out.append(f"{called} {near}")
        else:
            numbers = ", ".join(f"{v:.1f}".replace("-0.0", "0.0") for v in vector)
            out.append(f"{called} along ({numbers}) in {frame}")
    return tuple(out)


__all__ = ["Directions", "aligned", "directions", "in_words"]

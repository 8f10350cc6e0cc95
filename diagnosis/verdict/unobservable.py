"""What of an effect's numbers a recording does not show, in the words of somebody who looks at the rig.

The covariance is that of the fit linearised at its own motion. Noise in that motion shakes it, and what is shaken seems
to be seen: of a sensor that turns about the hinge axis alone, where it sits along that axis comes out as known to
some 10 mm, though nothing shows it. So a direction that is named is not seen; one that is not named may be.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.directions import Directions, directions, in_words
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.problem.rig_kinematics import HINGE_AXIS
from imubench.diagnosis.result import Parameter
from imubench.effects.effect import Parameter as Number
from imubench.models.tree import BALL, FREE, HINGE

MATRIX_ENTRIES = {6: ("xy", "xz", "yx", "yz", "zx", "zy"), 9: tuple(a + b for a in "xyz" for b in "xyz")}
OF_SEGMENT = {
    HINGE: ("along the segment", "along the hinge axis", "across the segment and the hinge axis"),
    BALL: ("along x of the limb", "along y of the limb", "along the limb"),
    FREE: ("along x of the segment", "along y of the segment", "along z of the segment"),
}
"""What the axes of a segment's frame are, by the joint that holds it."""


def widened(fit: Fit, covariance: Array, white: Mapping[str, Array], std: Mapping[str, Array]) -> Array:
    """Return a covariance (p, p) of white noise with the standard deviations that all else makes of it.

    Args:
        fit: whose parameters these are.
        covariance: of white noise.
        white: its standard deviations (k,) by parameter.
        std: those that count, colour of the noise and springs' own intervals in them.
    """
    factor = np.ones(len(covariance))
    for name, before in white.items():
        factor[fit.model.parameters.columns(name)] = std[name] / before
    return np.asarray(covariance * np.outer(factor, factor))


def seen_of(fit: Fit, h: Hypothesis, covariance: Array) -> dict[str, Directions]:
    """Return for each fitted number of an effect that is reported, by its name, which directions of it are seen."""
    out = {}
    for p in h.effect.parameters:
        if p.reported:
            key = h.key(p.name)
            places = fit.model.parameters.places([key])
            own = covariance[np.ix_(places, places)]
            found = directions(own, np.broadcast_to(fit.model.priors[key].std, (p.width,)), from_none(p))
            if p.log:  # the fit's number is the logarithm
                value = np.exp(fit.state.values[key])
                found = replace(found, covariance=own * np.outer(value, value))
            out[p.name] = found
    return out


def from_none(p: Number) -> bool:
    """Return whether zeros of a parameter mean that there is nothing."""
    return not p.log and not np.any(p.centre)


def with_directions(parameters: Mapping[str, Parameter], seen: Mapping[str, Directions]) -> dict[str, Parameter]:
    """Return parameters with the directions that are seen, where these are known."""
    return {name: replace(p, fixed=seen.get(name)) for name, p in parameters.items()}


def unseen_in_words(fit: Fit, h: Hypothesis, seen: Mapping[str, Directions]) -> tuple[str, ...]:
    """Return the directions of an effect's numbers that are not seen, as they stand after "the"."""
    out: list[str] = []
    for name, found in seen.items():
        axes, frame = named_axes(fit, h, name, len(found.unseen))
        out += in_words(name, found.unseen, axes, frame)
    return tuple(out)


def named_axes(fit: Fit, h: Hypothesis, name: str, width: int) -> tuple[dict[str, Array], str]:
    """Return the directions of a parameter's numbers that have a name, and what frame the numbers are in."""
    kind = fit.model.recording.tree.kind
    if width in MATRIX_ENTRIES:
        return {
            f"entry {entry}": axis for entry, axis in zip(MATRIX_ENTRIES[width], np.eye(width), strict=True)
        }, "its entries"
    if width != 3:
        return {f"number {i + 1}": axis for i, axis in enumerate(np.eye(width))}, "its numbers"
    number = next(p for p in h.effect.parameters if p.name == name)
    if number.axes == "segment":
        return dict(zip(OF_SEGMENT[kind], np.eye(3), strict=True)), "segment axes"
    word = "about" if number.about else "along"
    own = {f"{word} {axis} of the sensor": e for axis, e in zip("xyz", np.eye(3), strict=True)}
    hinge = {}
    if kind == HINGE and h.at in fit.model.mounts and word == "about":
        hinge = {"about the hinge axis": fit.model.mounts[h.at].turn.T @ np.eye(3)[HINGE_AXIS]}
    return hinge | own, "sensor axes"


__all__ = ["named_axes", "seen_of", "unseen_in_words", "widened", "with_directions"]

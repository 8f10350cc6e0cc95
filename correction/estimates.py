"""What the project's estimators make of a recording as it came, and without what its diagnosis found in it.

With E(S) the estimate from the recording without all findings but those of S, F all of them, d the difference that
`imubench.answers.moved` takes (deg between axes, mm between vectors), all findings move the estimate by
d(E(F), E(none)) and one finding f moves it by d(E({f}), E(none)): it alone is left in. So the numbers are those of
`imubench estimate NAME` beside `imubench estimate NAME --with`, and so is how far they are from a reference: that is
carried to each sensor by its own gyroscope, and a clock that is off turns it as well.
"""

from collections.abc import Iterator, Mapping
from contextlib import suppress

import numpy as np

from imubench.answers import moved
from imubench.arrays import Array
from imubench.correction.corrected import Removal, removal
from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.evidence import Estimated
from imubench.diagnosis.result import Diagnosis
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.estimators import ESTIMATORS
from imubench.models.tree import BALL, HINGE
from imubench.progress import Step, silent
from imubench.recording import Recording
from imubench.reference import Reference
from imubench.reference_axes import reference_axes
from imubench.score import line_deviation

ASKED: Mapping[str, tuple[str, ...]] = {HINGE: ("olsson2020", "hinge-position"), BALL: ("mrvs",)}
"""Estimators of what a joint can be asked for: a hinge's axis and centre, a ball joint's centre by what costs least."""


def estimates(
    recording: Recording, diagnosis: Diagnosis, reference: Reference | None = None, step: Step = silent
) -> tuple[Estimated, ...]:
    """Return what every estimator of a rig makes of a recording, and by how much the findings move that.

    Args:
        recording: as it came.
        diagnosis: of it.
        reference: an independent record of the motion, which may show where a hinge's axes are; None: there is none.
        step: told what is being done.

    Returns:
        One for each estimator that takes the recording; none where nothing that was found can be taken out.

    Raises:
        InputError: where the findings cannot be taken out, see `correction`.
    """
    some = any(f.named and f.confidence >= CONFIDENCE.counts for f in diagnosis.findings)
    asked = [name for name in ASKED.get(recording.tree.kind, ()) if ESTIMATORS[name].imus <= len(recording.imus)]
    if not some or not asked or diagnosis.doubts:
        return ()
    taking_out = removal(recording, diagnosis, step)
    return tuple(one for name in asked if (one := estimated(name, taking_out, reference)) is not None)


def estimated(name: str, taking_out: Removal, reference: Reference | None) -> Estimated | None:
    """Return what an estimator makes of a recording without and with what was found; None where it takes it not."""
    both = taking_out.recording, taking_out.without().recording
    try:
        came, without = (ESTIMATORS[name].estimate(one) for one in both)
    except InputError:
        return None
    by = moved(without, came)
    if by is None:
        return None
    was, now = (
        beside(answer, reference_axes(one, reference)) for answer, one in zip((came, without), both, strict=True)
    )
    off = None if was is None or now is None else (was, now)
    each = dict(each_alone(name, taking_out, without))
    every = [(f.effect, f.at) for f in taking_out.diagnosis.findings]
    imus = tuple(imu.name for imu in taking_out.recording.imus[: len(by[0])])
    status = came.status, without.status
    return Estimated(name, came.quantity, by[1], imus, by[0], tuple(each.get(place) for place in every), off, status)


def each_alone(name: str, taking_out: Removal, without: Estimate) -> Iterator[tuple[tuple[str, str], Array]]:
    """Yield by how much each finding that has a law moves an estimate, by effect and place, if it alone is left in."""
    for f in taking_out.found:
        with suppress(InputError):
            left = ESTIMATORS[name].estimate(taking_out.without(((f.effect, f.at),)).recording)
            if (by := moved(without, left)) is not None:
                yield (f.effect, f.at), by[0]


def beside(answer: Estimate, axes: Array | None) -> Array | None:
    """Return the angles (m,) deg between estimated axes and others (m, 3), as lines; None without any."""
    return (
        np.degrees(line_deviation(answer.value, axes)) if answer.quantity == "joint_axis" and axes is not None else None
    )


__all__ = ["ASKED", "estimated", "estimates"]

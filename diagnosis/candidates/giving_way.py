"""What gives way by more than any gyroscope's noise: the mounts of both IMUs, and the hinge between them beside these.

What a rigid model leaves then is no noise, and effects that come in one by one are judged by levels that the others
have raised. So springs under both IMUs (`both_mounts`) come in before the search, if they predict left-out data better
than a loose joint does, whose rotations across the axis are splines without a law. A loose joint comes in beside them
where that predicts better still; where springs explain most, only if it explains most of the rest: beside springs that
have yet to settle its splines take in something of anything. A loose joint alone is left to the search: they take in
what one sprung mount does, or one that shifts.
"""

from collections.abc import Iterable, Iterator
from contextlib import suppress

import numpy as np

from imubench.diagnosis.candidates.both_mounts import gyro_power, louder_than_any, on_springs, takes_away
from imubench.diagnosis.config.candidates import GIVING_WAY
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.criteria.cross_validation import log_score_gain
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import refit
from imubench.effects import possible
from imubench.progress import tell


def with_what_gives_way(rigid: Fit) -> Fit | None:
    """Return the fit of a hinge with both IMUs on springs, its joint loose if need be; None where that is not it."""
    if rigid.model.recording.tree.hinge is None or not louder_than_any(rigid):
        return None
    tell("looking for springs under both IMUs")
    with suppress(NotPositiveDefiniteError):
        sprung = on_springs(rigid)
        if sprung is None or not predicts_better(rigid, sprung):
            return None
        tell("looking for a loose joint beside them")
        if explains_most(rigid, sprung):
            found = best_of(sprung, (f for f in loosened(sprung, GIVING_WAY.explained) if explains_most(sprung, f)))
        else:
            found = best_of(sprung, loosened(sprung, GIVING_WAY.left))
            if found is sprung:
                return None
        rival = best_of(rigid, loosened(rigid, GIVING_WAY.left))
        return found if rival is rigid or predicts_better(rival, found) else None
    return None


def best_of(fit: Fit, others: Iterable[Fit]) -> Fit:
    """Return the fit that predicts left-out data best, a further one where it does so for sure."""
    for other in others:
        fit = other if predicts_better(fit, other) else fit
    return fit


def predicts_better(fit: Fit, other: Fit) -> bool:
    """Return whether another fit predicts left-out data better than a fit, each at its own noise."""
    return log_score_gain(fit, other, np.random.default_rng(STATISTICS.seed)).is_sure()


def explains_most(fit: Fit, other: Fit) -> bool:
    """Return whether another fit takes away most of what a fit leaves of the gyroscopes."""
    return gyro_power(other) < GIVING_WAY.explained * gyro_power(fit)


def loosened(fit: Fit, most: float) -> Iterator[Fit]:
    """Yield fits with a joint that is loose, in every way that needs no law.

    Only where first steps leave less than the share `most` of the gyroscopes' power that a fit leaves.
    """
    for h in (Hypothesis(e, at) for e, at in possible(fit.model.recording) if e.loosens and not e.lawful):
        with suppress(NotPositiveDefiniteError):
            found = refit(fit, (*fit.model.hypotheses, h))
            if takes_away(fit, found, most):
                yield with_noise(found, 2 * REML.rounds)


__all__ = ["with_what_gives_way"]

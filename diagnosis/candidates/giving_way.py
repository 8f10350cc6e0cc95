"""What gives way by more than any gyroscope's noise: the mounts of both IMUs, and the hinge between them beside these.

What a rigid model leaves then is no noise, and effects that come in one by one are judged by levels that the others
have raised. So springs under both IMUs (`both_mounts`) come in before the search, if they predict left-out data better
than a loose joint does: its rotations across the axis, splines without a law, take in what one sprung mount does as
well, and which of the two it is the search tells. Where springs leave much of the power, a loose joint comes in beside
them.
"""

from collections.abc import Iterator
from contextlib import suppress
from itertools import chain

import numpy as np

from imubench.diagnosis.candidates.both_mounts import first_steps, gyro_power, louder_than_any, on_springs
from imubench.diagnosis.config.candidates import GIVING_WAY
from imubench.diagnosis.config.noise import REML
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.criteria.cross_validation import log_score_gain
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.effects import possible
from imubench.progress import tell


def with_what_gives_way(rigid: Fit) -> Fit | None:
    """Return the fit of a hinge with both IMUs on springs, its joint loose if need be; None where that is not it."""
    if rigid.model.recording.tree.hinge is None or not louder_than_any(rigid):
        return None
    tell("looking for springs under both IMUs")
    with suppress(NotPositiveDefiniteError):
        sprung = on_springs(rigid)
        if sprung is None or not all(predicts_better(other, sprung) for other in chain((rigid,), loosened(rigid))):
            return None
        if gyro_power(sprung) < GIVING_WAY.explained * gyro_power(rigid):
            return sprung
        tell("looking for a loose joint beside them")
        best = sprung
        for both in loosened(sprung):
            best = both if predicts_better(best, both) else best
        return None if best is sprung else best
    return None


def predicts_better(fit: Fit, other: Fit) -> bool:
    """Return whether another fit predicts left-out data better than a fit, each at its own noise."""
    return log_score_gain(fit, other, np.random.default_rng(STATISTICS.seed)).is_sure()


def loosened(fit: Fit) -> Iterator[Fit]:
    """Yield fits with a joint that is loose, in every way that needs no law, as far as first steps promise much."""
    for h in (Hypothesis(e, at) for e, at in possible(fit.model.recording) if e.loosens and not e.lawful):
        begun = extended(fit, (*fit.model.hypotheses, h))
        with suppress(NotPositiveDefiniteError):
            found = first_steps(fit, begun)
            if found is not None:
                yield with_noise(found, 2 * REML.rounds)


__all__ = ["with_what_gives_way"]

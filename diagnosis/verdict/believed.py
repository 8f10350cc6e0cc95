"""The fit that a user is told the motion of: with what is believed, and with nothing else."""

from collections.abc import Sequence

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.noise.masking import Masks, weighed_beside
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.result import Finding
from imubench.diagnosis.solve.refit import refit_without


def believed(fit: Fit, named: Sequence[Finding], sound: Masks | None) -> Fit:
    """Return the fit without the effects that are not likely, at the noise that it then leaves.

    A name that something without one equals may be there or not; what it lets the motion do, a slip that hides the
    samples of its moment for one, is not to be taken for what the rig did.

    Args:
        fit: with every finding in it.
        named: the findings with a name and how likely each is.
        sound: the samples that count beside no effect, by group; None: all.

    Returns:
        The fit itself where each of its effects is likely.
    """
    likely = {(f.effect, f.at) for f in named if f.confidence >= CONFIDENCE.counts}
    told = {(f.effect, f.at) for f in named}
    gone = [h for h in fit.model.judged for one in [(h.effect.name, h.at)] if one in told and one not in likely]
    if not gone:
        return fit
    left = refit_without(fit, gone)
    return with_noise(weighed_beside(left, left.model.judged, sound))


__all__ = ["believed"]

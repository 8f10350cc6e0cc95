"""Which effects with states a round of the search tries, and what they must promise."""

from collections.abc import Collection

from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.noise import COHERENCE
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.trial import Trial, kind
from imubench.diagnosis.noise.coherence import follows_motion
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.refit import evidence_over

CLEARLY = 100.0  # nat: of springs, from which on a spline without a law is tried too; of a name to ask with a clock's
LEAST_SHARE_OF_MISFIT = 0.08  # of what is left
FREE_FACTOR = 2.0  # times what effects without states explain: from there a spline without a law comes before them


def stateful(
    fit: Fit, left: list[Hypothesis], moving: bool, rivalled: bool, heard: Collection[str] = ()
) -> list[Hypothesis]:
    """Return the effects with states that a round tries: all where something seems to have a motion of its own.

    Otherwise only those with a law: a mount on stiff springs leaves little more than noise, which goes with the motion
    no more than the residuals of a misalignment do. Of these only springs where they have a rival without states
    (`rivalled`), and none where another effect with states is at an IMU, because what that leaves is more than its law
    allows. No filter beside a clock's offset that leaves little, because the filter would take the delay too; the two
    are compared at the end (`swap_clock_for_filter`). Filters in `heard` are the exception: they were worth much before
    something else came in. No filter beside a torque that jumps either, while little is left: the spline rounds the
    corners of such a motion as a filter would round its readings.
    """
    delayed = (
        any(h.effect.late_by or h.effect.torque_jumps for h in fit.model.hypotheses)
        and misfit(fit) <= ADMISSION.unexplained_misfit
    )
    there = {kind(h) for h in fit.model.hypotheses}
    alive = [h for h in left if h.effect.states and h.effect.variant != "isotropic" and kind(h) not in there]
    untold = delayed or (rivalled and not moving)
    alive = [h for h in alive if not (untold and h.effect.filters and h.name not in heard)]
    if moving:
        return alive
    taken = any(h.effect.states and (h.effect.free or h.effect.place == "imu") for h in fit.model.hypotheses)
    return [] if taken else [h for h in alive if h.effect.lawful]


def promised_by_law(fit: Fit) -> float:
    """Return the nat that springs must promise, and be worth, beside a pose whose errors wander: a share of the misfit.

    There the noise of the IMUs is estimated, so the residuals cost a half per number whatever is left out. Quick turns
    of a screwed-on IMU promise a few percent of that to springs, foam several times as much (lab/019).
    """
    imus = {i.name for i in fit.model.recording.imus}
    left = sum(r.cost for r in fit.measured if r.name.split(".")[0] in imus)
    return LEAST_SHARE_OF_MISFIT * left if fit.model.wander else 0.0


def suspicious(fit: Fit) -> bool:
    """Return whether a sensor or a joint may have a motion of its own that the fit does not know.

    Once such a motion is in, what is left must be more than its law's approximations. Beside a pose whose errors wander
    neither tells: such errors go with the attitude, and a real sensor at rest is quieter than one that is moved.
    """
    if fit.model.wander:
        return False
    if misfit(fit) > ADMISSION.unexplained_misfit:
        return True
    alive = any(h.effect.states for h in fit.model.hypotheses)
    return not alive and max(follows_motion(fit).values(), default=0.0) > COHERENCE.follows


def before_plain(lively: Trial, fit: Fit, further: Fit) -> bool:
    """Return whether an effect with states explains more than those without that made `further` of the fit."""
    plainly = evidence_over(fit, further)
    return lively.evidence > max(
        EVIDENCE.needed_nat, plainly if lively.hypothesis.effect.lawful else FREE_FACTOR * plainly
    )


__all__ = ["CLEARLY", "before_plain", "promised_by_law", "stateful", "suspicious"]

"""Backward deletion: what the fit can do without."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import EVIDENCE, STATISTICS
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.cross_validation import predicted
from imubench.diagnosis.criteria.dynamic_aic import tightened
from imubench.diagnosis.criteria.plausible_fit import natural
from imubench.diagnosis.criteria.trial import Gain, Kept
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.looser_motion import rougher
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, linear_in
from imubench.diagnosis.search.moves.move import Above, Proposal, Proposals, SearchState
from imubench.diagnosis.solve.refit import evidence_over, information, refit_without
from imubench.diagnosis.solve.subset import excerpt, loudest
from imubench.progress import tell


class Drop:
    """The fit without the effects that it no longer needs, weakest first; no colour of noise was what is `firm`.

    What an effect is worth is asked anew, and known from then on, whether anything is dropped or not.
    """

    def propose(self, state: SearchState) -> Proposals:
        """Yield the fit without its weakest effect; where that stays, without what the noise's colour may be."""
        while state.kept:
            covariance, std = information(state.fit)
            kept, losable = weakest(state.fit, state.kept, covariance)
            if losable is not None:
                k, without = losable
                answer = yield without_one(state, kept, k, without, -spare(k, without))
                state = answer.state
                if answer.accepted:
                    continue
            kept = in_colour(state.fit, kept, covariance, std, state.firm)
            k = min(kept, key=lambda k: k.evidence)
            if k.evidence <= EVIDENCE.needed_nat:
                tell(f"doing without {k.hypothesis.name}, which the noise's colour may be")
            answer = yield without_one(state, kept, k, None, EVIDENCE.needed_nat - k.evidence)
            state = answer.state
            if not answer.accepted:
                return


def without_one(state: SearchState, kept: Sequence[Kept], k: Kept, without: Fit | None, too_little: float) -> Proposal:
    """Return the proposal to do without an effect that is worth `too_little`, in nat; 0 where just so much.

    Where it stays, the state knows what each of `kept` is worth. `without` is the fit without it, None where that is
    still to be made.
    """
    worth = k.evidence if np.isfinite(k.evidence) else 0.0  # not natural: worth nothing
    weighed = replace(state, kept=tuple(kept), weighed=state.fit)

    def after(_: Gain | None) -> SearchState:
        fit = _without(state.fit, k.hypothesis) if without is None else without
        return weighed.without(((k.hypothesis, worth),), with_noise(fit, 2))

    return Proposal(f"without {k.hypothesis.name}", after, (Above(lambda: too_little, 0.0, reached=True),), weighed)


def changed(state: SearchState) -> bool:
    """Return whether the fit is another than when it was last asked what it can do without."""
    return state.fit is not state.weighed


def weakest(fit: Fit, kept: Sequence[Kept], covariance: Array) -> tuple[list[Kept], tuple[Kept, Fit] | None]:
    """Return the effects with what they are worth now, and the weakest one with the fit without it.

    None where that is worth so much that it was not fitted, or is the only one and was judged already.
    """
    if len(kept) <= 1 and all(EVIDENCE.needed_nat < k.evidence < np.inf and natural(fit, k.hypothesis) for k in kept):
        return list(kept), None
    judged = []
    for k in kept:
        tell(f"trying to do without {k.hypothesis.name}")
        if natural(fit, k.hypothesis):
            loss, without = lost_without(fit, k, covariance)
        else:
            loss, without = -np.inf, _without(fit, k.hypothesis)
        judged.append((_judged(replace(k, evidence=loss), without, fit), without))
    k, without = min(judged, key=lambda x: spare(*x))
    return [k for k, _ in judged], None if without is None else (k, without)


def firmly(fit: Fit, kept: Sequence[Kept]) -> list[Hypothesis]:
    """Return the effects that are next to linear and certain in noise as coloured as the residuals show.

    Asked of a fit before its knots become finer for springs that ring. With more knots than samples the motion is free
    between the samples of a sensor, and what is aliased there looks slow: the intervals of slow errors, such as a bias,
    widen.
    """
    linear = [k for k in kept if linear_in(k.hypothesis)]
    if not linear:
        return []
    return [k.hypothesis for k in in_colour(fit, linear, *information(fit)) if k.evidence > EVIDENCE.certain_nat]


def in_colour(
    fit: Fit, kept: Sequence[Kept], covariance: Array, std: dict[str, Array], firm: Collection[Hypothesis] = ()
) -> list[Kept]:
    """Return the effects with the evidence that they have where the noise is as coloured as the residuals show.

    Effects in `firm` keep their evidence. `covariance` (p, p) and `std` are those of `information`. A clock's offset
    has the evidence of a rougher motion if that is less, because a motion held too smooth is late where it turns. So
    has the pose of a second IMU, of the cost alone: a smooth motion has more room about a short lever, and a displaced
    IMU would make the other one seem displaced too.
    """
    linear = [k for k in kept if linear_in(k.hypothesis) and k.hypothesis not in firm]
    if not linear:
        return list(kept)
    wider = np.ones(len(covariance))
    for name, coloured in parameter_std(fit).items():
        wider[fit.model.parameters.columns(name)] = np.maximum(coloured / std[name], 1.0)
    covariance = covariance * np.outer(wider, wider)
    told = {k.hypothesis: min(k.evidence, about_zero(fit, [k.hypothesis], covariance)) for k in linear}
    for h in [h for h in told if h.effect.late_by]:
        told[h] = min(told[h], about_zero(rougher(fit), [h], covariance))
    poses = [h for h in told if h.effect.misplaces]
    for h in poses if len(poses) > 1 else []:
        told[h] = min(told[h], costs_more(rougher(_without(fit, h)), rougher(fit)))
    return [replace(k, evidence=told.get(k.hypothesis, k.evidence)) for k in kept]


def costs_more(without: Fit, fit: Fit) -> float:
    """Return the nat by which one fit's rows, samples and priors, cost more than another's."""
    return sum(r.cost for r in without.rows) - sum(r.cost for r in fit.rows)


def needed(h: Hypothesis) -> float:
    """Return the nat that an effect must be worth to stay; splines of its own fit more, and by a Gaussian's price."""
    return EVIDENCE.state_nat if h.effect.states else EVIDENCE.needed_nat


def lost_without(fit: Fit, kept: Kept, covariance: Array) -> tuple[float, Fit | None]:
    """Return the evidence lost without an effect, and the fit without; none where the loss is plain before fitting.

    Plain: by the Gaussian about the fit (Savage and Dickey's ratio), or on a part of the recording already.
    """
    h = kept.hypothesis
    linear = linear_in(h)
    if np.isfinite(kept.evidence):
        if linear:
            loss = about_zero(fit, [h], covariance)
        else:
            short = excerpt(fit, *loudest(fit, ADMISSION.screened_s))
            loss = aic_gain(_without(short, h), short)
        if loss > EVIDENCE.certain_nat:
            return loss, None
    return price_of_dropping(fit, h)


def price_of_dropping(fit: Fit, h: Hypothesis) -> tuple[float, Fit]:
    """Return the nat that it costs to do without an effect, and the fit without it.

    An effect with states is judged with its law as tight as it bears, where that decides: with a looser law its
    freedoms alone may cost more than it gains.
    """
    without = _without(fit, h)
    if not h.effect.states:
        return evidence_over(without, fit), without
    lost = aic_gain(without, fit)
    tight = tightened(fit, [h]) if h.effect.lawful and lost < needed(h) else None
    return (lost if tight is None else max(lost, aic_gain(without, tight))), without


def _without(fit: Fit, h: Hypothesis) -> Fit:
    return refit_without(fit, [h], steps=4)


def about_zero(fit: Fit, gone: Sequence[Hypothesis], covariance: Array) -> float:
    """Return the log ratio of prior to posterior density where every parameter of `gone` is at its prior's centre.

    covariance (p, p) is of all the fit's parameters.
    """
    return at_centre(fit, [h.key(p.name) for h in gone for p in h.effect.parameters], covariance)


def at_centre(fit: Fit, names: Sequence[str], covariance: Array) -> float:
    """Return the same of some parameters by name."""
    at = fit.model.parameters.places(names)
    priors = [fit.model.priors[name] for name in names]
    away = np.concatenate([fit.state.values[name] for name in names])
    away = (away - np.concatenate([p.start for p in priors])) / np.concatenate([p.std for p in priors])
    std = np.concatenate([p.std for p in priors])
    own = covariance[np.ix_(at, at)] / np.outer(std, std)
    return 0.5 * float(away @ np.linalg.solve(own, away)) + 0.5 * float(np.linalg.slogdet(own)[1])


def spare(kept: Kept, without: Fit | None) -> float:
    """Return the nat by which an effect is worth more than it must be; below 0 where it predicts nothing for sure."""
    more = kept.evidence - needed(kept.hypothesis)
    foretells = without is None or not kept.heldout.value or kept.heldout.is_sure()
    return more if foretells else min(more, kept.heldout.low)


def _judged(kept: Kept, without: Fit | None, fit: Fit) -> Kept:
    """Return an effect that was in the model from the start with what it gains on held-out data."""
    if kept.heldout.value or kept.evidence < EVIDENCE.needed_nat or without is None:
        return kept
    return replace(kept, heldout=predicted(without, fit, np.random.default_rng(STATISTICS.seed)))

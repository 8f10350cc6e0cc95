"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis.blocks import NotPositiveDefiniteError
from imubench.diagnosis.coherence import follows_motion
from imubench.diagnosis.excerpt import excerpt, loudest
from imubench.diagnosis.fit import Fit, settled, solve
from imubench.diagnosis.grids import placed
from imubench.diagnosis.heldout import Gain, Held, gain, held_out
from imubench.diagnosis.model import Hypothesis, Model
from imubench.diagnosis.noise import declared, fit_with_noise
from imubench.diagnosis.refit import extended, information, log_evidence, refit
from imubench.diagnosis.score import Score, score
from imubench.diagnosis.screen import Screened, obeyed, screen
from imubench.effects import possible

MOST = 5  # effects in one diagnosis
TRIED = 3  # of the best scores, refitted exactly in each round
NEAR = 0.1  # of the best promise: a score below is not worth a refit
UNEXPLAINED = 1.4  # misfit above which a sensor's own motion is tried too; a declared noise explains up to 1.6
RELATED = 3.0  # of follows_motion, from which they are tried as well; clean recordings stay below 2
NEEDED = 5.0  # nat of evidence before an effect is looked at on held-out data: odds of 150 for some 60 candidates
CERTAIN = 30.0  # nat that an effect is worth without looking closer
SCREENED = 15.0  # s of a recording on which effects with states are tried first
ROUNDS = 3  # of their noise estimation
RIVALS = 0.3  # of the best one's promise: a state effect below is not worth a refit
SEED = 20201  # of the bootstrap, so that a diagnosis repeats itself


@dataclass(frozen=True)
class Trial:
    """A refit with one effect more, and what it gained on the data it was fitted to."""

    hypothesis: Hypothesis
    fit: Fit
    gain: float  # nat
    evidence: float  # nat


@dataclass(frozen=True)
class Kept:
    """An effect that stays."""

    hypothesis: Hypothesis
    evidence: float  # nat, over the model without it
    heldout: Gain
    rivals: tuple[Trial, ...]  # refitted in its round, in its place


@dataclass(frozen=True)
class Selection:
    """What was found, and the fits before and after."""

    nominal: Fit
    fit: Fit
    kept: tuple[Kept, ...]
    rejected: tuple[tuple[Hypothesis, float], ...]  # nat on held-out data, or of evidence where that was enough
    scores: tuple[Score, ...]  # of the nominal fit
    before: Held
    after: Held


def candidates(model: Model) -> list[Hypothesis]:
    """Return every effect at every place of a recording where it could act."""
    return [Hypothesis(effect, at) for effect, at in possible(model.recording) if effect.parameters or effect.states]


def plain_trials(fit: Fit, scores: list[Score], say: Callable[[str], None]) -> list[Trial]:
    """Return exact refits of the best scores, best evidence first."""
    best = max((s.evidence for s in scores), default=0.0)
    chosen = [s for s in scores if s.evidence > max(NEEDED, NEAR * best)][:TRIED]
    base = log_evidence(fit)
    out = []
    for s in chosen:
        say(f"refitting with {s.hypothesis.name}")
        tried = refit(fit, (*fit.model.hypotheses, s.hypothesis))
        out.append(Trial(s.hypothesis, tried, fit.cost - tried.cost, log_evidence(tried) - base))
    return sorted(out, key=lambda t: -t.evidence)


def state_trials(fit: Fit, stateful: list[Hypothesis], say: Callable[[str], None]) -> list[Trial]:
    """Return refits with effects that have a life of their own, best evidence first; none where none is needed.

    They are screened and tried on the seconds that leave most unexplained; only the best is fitted to all, first in
    the list. What the others gained there is scaled to the length of the whole.
    """
    short = excerpt(fit, *loudest(fit, SCREENED))
    say("screening effects with states")
    screened = [s for s in screen(short, stateful) if s.evidence > NEEDED]
    tried = []
    for s in [s for s in screened if s.evidence > RIVALS * screened[0].evidence][:TRIED]:
        say(f"refitting with {s.hypothesis.name}")
        with suppress(NotPositiveDefiniteError):
            tried.append(_lively(short, s))
    tried = sorted((t for t in tried if t.evidence > NEEDED), key=lambda t: -t.evidence)
    if not tried:
        return []
    best, *rest = tried
    say(f"refitting with {best.hypothesis.name} on the whole recording")
    try:
        grown = _grown(fit, best)
    except NotPositiveDefiniteError:
        return []
    scale = grown.evidence / best.evidence
    return [grown, *(replace(t, gain=t.gain * scale, evidence=t.evidence * scale) for t in rest if scale > 0)]


def _lively(fit: Fit, s: Screened) -> Trial:
    """Return the refit with a state effect, begun as its law says and where the law outweighs the measurements."""
    h = s.hypothesis
    begun = extended(fit, (*fit.model.hypotheses, h), s.values)
    noise = begun.noise | s.rough
    state = obeyed(begun.model, begun.state, h)[0] if h.effect.lawful else begun.state
    tried = solve(begun.model, state, calm(replace(begun, noise=noise)), fit.anchor, steps=4)
    tried = fit_with_noise(tried.model, tried.state, tried.noise, fit.anchor, rounds=ROUNDS)
    return _against(fit, h, tried)


def _grown(fit: Fit, trial: Trial) -> Trial:
    """Return a trial on a part of the recording as one on all of it."""
    h = trial.hypothesis
    guess = {name: value for name, value in trial.fit.state.values.items() if name not in fit.model.priors}
    begun = extended(fit, (*fit.model.hypotheses, h), guess)
    state = obeyed(begun.model, begun.state, h)[0] if h.effect.lawful else begun.state
    noise = begun.noise | trial.fit.noise
    state = settled(begun.model, state, noise, fit.anchor, fit.loose)
    tried = fit_with_noise(begun.model, state, noise, fit.anchor, rounds=2)
    return _against(fit, h, tried)


def _against(fit: Fit, h: Hypothesis, tried: Fit) -> Trial:
    """Return a refit beside the fit without its effect, each at its own noise levels."""
    won = log_evidence(tried) - log_evidence(fit)
    return Trial(h, tried, won, won)


def calm(fit: Fit) -> dict[str, float]:
    """Return noise levels to begin a spring's fit with: ten times the declared, so that its law outweighs a misfit."""
    told = declared(fit.model)
    return {name: 10 * told[name] if name in told else std for name, std in fit.noise.items()}


def misfit(fit: Fit) -> float:
    """Return the mean over the sensors of noise power left over noise power declared; 1 where none is declared."""
    told = declared(fit.model)
    return float(np.mean([(fit.noise[n] / std) ** 2 for n, std in told.items() if n in fit.noise] or [1.0]))


def select(nominal: Fit, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the effects that the recording needs."""
    fit, rejected = nominal, []
    kept = [Kept(h, np.inf, Gain(0.0, 0.0, 0.0, np.zeros(1)), ()) for h in nominal.model.hypotheses]
    first: tuple[Score, ...] = ()
    start = held_out(nominal)
    rng = np.random.default_rng(SEED)
    everything = candidates(nominal.model)
    while len(kept) < MOST:
        say("scoring every effect")
        taken = {h.name for h in fit.model.hypotheses}
        left = [h for h in everything if h.name not in taken]
        plain, judged = placed(fit, [h for h in left if not h.effect.states])
        scores = sorted([*score(fit, plain), *judged], key=lambda s: -s.evidence)
        first = first or tuple(scores)
        tried = [t for t in plain_trials(fit, scores, say) if t.evidence > NEEDED]
        better = with_noise(tried[0].fit) if tried else fit
        if tried and (windows := blind(better, tried[0].hypothesis)):
            better, fit = with_noise(blinded(better, windows)), blinded(fit, windows)
        if suspicious(better):
            lively = state_trials(fit, [h for h in left if h.effect.states and h.effect.variant != "isotropic"], say)
            if lively and lively[0].evidence > max(NEEDED, log_evidence(better) - log_evidence(fit)):
                tried, better = lively + tried, lively[0].fit
        if not tried:
            break
        best = tried[0]
        say(f"predicting held-out data with {best.hypothesis.name}")
        ruler = solve(fit.model, fit.state, {n: better.noise[n] for n in fit.noise}, fit.anchor, steps=3)
        after = held_out(better)
        won = gain(held_out(ruler), after, rng)
        if won.low <= 0:
            rejected.append((best.hypothesis, won.value))
            break
        kept.append(Kept(best.hypothesis, best.evidence, won, tuple(tried[1:])))
        fit = better
    fit, kept, dropped = prune(fit, kept, say)
    first_at_end = solve(
        nominal.model, nominal.state, {n: fit.noise[n] for n in nominal.noise}, nominal.anchor, steps=3
    )
    start = held_out(first_at_end) if kept else start
    return Selection(nominal, fit, tuple(kept), (*rejected, *dropped), first, start, held_out(fit) if kept else start)


def blind(fit: Fit, h: Hypothesis) -> dict[str, NDArray[np.bool_]]:
    """Return the samples that count besides those in which an effect acts as its law does not say; none: all do."""
    windows = h.effect.blind({p.name: fit.state.values[h.key(p.name)] for p in h.effect.parameters})
    masks = {}
    for name, stamps in fit.model.stamps.items():
        if windows and name.split(".")[0] == h.at:
            time = stamps - fit.model.start
            masks[name] = ~np.any([(time >= a) & (time <= b) for a, b in windows], axis=0)
    return masks


def blinded(fit: Fit, counted: dict[str, NDArray[np.bool_]]) -> Fit:
    """Return the fit on those samples alone, noise levels as they were."""
    known = fit.model.masks or {}
    masks = known | {name: mask & known.get(name, mask) for name, mask in counted.items()}
    return solve(replace(fit.model, masks=masks), fit.state, fit.noise, fit.anchor, steps=3)


def suspicious(fit: Fit) -> bool:
    """Return whether a sensor or a joint may have a motion of its own that the fit does not know.

    Once such a motion is in, what is left must be more than its law's approximations.
    """
    if misfit(fit) > UNEXPLAINED:
        return True
    alive = any(h.effect.states for h in fit.model.hypotheses)
    return not alive and max(follows_motion(fit).values(), default=0.0) > RELATED


def with_noise(fit: Fit) -> Fit:
    """Return a fit with the noise levels that it leaves."""
    return fit_with_noise(fit.model, fit.state, fit.noise, fit.anchor, rounds=3)


def prune(
    fit: Fit, kept: list[Kept], say: Callable[[str], None]
) -> tuple[Fit, list[Kept], list[tuple[Hypothesis, float]]]:
    """Return the fit without the effects that it no longer needs, weakest first."""
    dropped: list[tuple[Hypothesis, float]] = []
    while len(kept) > 1 or any(np.isinf(k.evidence) for k in kept):
        losses = []
        for k in kept:
            say(f"trying to do without {k.hypothesis.name}")
            losses.append((*lost_without(fit, k), k))
        loss, without, k = min(losses, key=lambda x: x[0])
        kept = [_judged(replace(k, evidence=loss), without, fit) for loss, without, k in losses]
        if loss > NEEDED or without is None:
            return fit, kept, dropped
        dropped.append((k.hypothesis, loss))
        kept = [other for other in kept if other.hypothesis != k.hypothesis]
        fit = fit_with_noise(without.model, without.state, without.noise, fit.anchor, rounds=2)
    return fit, kept, dropped


def lost_without(fit: Fit, kept: Kept) -> tuple[float, Fit | None]:
    """Return the evidence lost without an effect, and the fit without; none where the loss is plain before fitting.

    Plain: by the Gaussian about the fit (Savage and Dickey's ratio), or on a part of the recording already.
    """
    h = kept.hypothesis
    if np.isfinite(kept.evidence):
        if not h.effect.states and not any(p.log for p in h.effect.parameters):
            loss = about_zero(fit, h)
        else:
            short = excerpt(fit, *loudest(fit, SCREENED))
            loss = log_evidence(short) - log_evidence(_without(short, h))
        if loss > CERTAIN:
            return loss, None
    without = _without(fit, h)
    return log_evidence(fit) - log_evidence(without), without


def _without(fit: Fit, h: Hypothesis) -> Fit:
    short = extended(fit, tuple(other for other in fit.model.hypotheses if other != h))
    return solve(short.model, short.state, short.noise, fit.anchor, steps=4)


def about_zero(fit: Fit, h: Hypothesis) -> float:
    """Return the log ratio of the prior's to the posterior's density where every parameter is at its prior's centre."""
    covariance, _ = information(fit)
    at = np.concatenate([np.r_[fit.model.parameters.columns(h.key(p.name))] for p in h.effect.parameters])
    priors = [fit.model.priors[h.key(p.name)] for p in h.effect.parameters]
    away = np.concatenate([fit.state.values[h.key(p.name)] for p in h.effect.parameters])
    away = (away - np.concatenate([p.start for p in priors])) / np.concatenate([p.std for p in priors])
    std = np.concatenate([p.std for p in priors])
    own = covariance[np.ix_(at, at)] / np.outer(std, std)
    return 0.5 * float(away @ np.linalg.solve(own, away)) + 0.5 * float(np.linalg.slogdet(own)[1])


def _judged(kept: Kept, without: Fit | None, fit: Fit) -> Kept:
    """Return an effect that was in the model from the start with what it gains on held-out data."""
    if kept.heldout.value or kept.evidence < NEEDED or without is None:
        return kept
    return replace(kept, heldout=gain(held_out(without), held_out(fit), np.random.default_rng(SEED)))

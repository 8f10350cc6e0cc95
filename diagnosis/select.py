"""Which effects the fit needs: score all, refit the best few exactly, keep what predicts, drop what it does without."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis.coherence import follows_motion
from imubench.diagnosis.exchange import exchanged
from imubench.diagnosis.filtered import filtered
from imubench.diagnosis.fit import Fit, at_noise_of, solve
from imubench.diagnosis.grids import placed
from imubench.diagnosis.heldout import Gain, predicted
from imubench.diagnosis.lively import RIVALS, calm, state_trials
from imubench.diagnosis.model import Hypothesis, Model
from imubench.diagnosis.noise import fit_with_noise
from imubench.diagnosis.prune import SEED, natural, prune
from imubench.diagnosis.refit import log_evidence, refit
from imubench.diagnosis.score import Score, score
from imubench.diagnosis.trial import NEEDED, TRIED, Kept, Trial, misfit
from imubench.effects import possible

MOST = 5  # effects in one diagnosis
NEAR = 0.1  # of the best promise: a score below is not worth a refit
UNEXPLAINED = 1.4  # misfit above which a sensor's own motion is tried too; a declared noise explains up to 1.6
BESIDE = 0.5  # s of recording on either side of a moment; without them it was so all along
AHEAD = 3  # effects without states that are tried together before one with states is
LITTLE = 0.7  # of the excess misfit: an effect that leaves more has not explained it
TWICE = 2.0  # times what effects without states explain: from there a spline without a law comes before them
SETTLED = 8  # rounds at most, of a law that the fit ends with
RELATED = 3.0  # of follows_motion, from which they are tried as well; clean recordings stay below 2


@dataclass(frozen=True)
class Selection:
    """What was found, and the fit with it."""

    fit: Fit
    kept: tuple[Kept, ...]
    rejected: tuple[tuple[Hypothesis, float], ...]  # nat on held-out data, or of evidence where that was enough


def candidates(model: Model) -> list[Hypothesis]:
    """Return every effect at every place of a recording where it could act."""
    return [Hypothesis(effect, at) for effect, at in possible(model.recording) if effect.parameters or effect.states]


def plain_trials(fit: Fit, scores: list[Score], say: Callable[[str], None], most: int = TRIED) -> list[Trial]:
    """Return exact refits of the best scores, at `most` so many, best evidence first."""
    best = max((s.evidence for s in scores), default=0.0)
    chosen = [s for s in scores if s.evidence > max(NEEDED, NEAR * best)][:most]
    base = log_evidence(fit)
    out = []
    for s in chosen:
        say(f"refitting with {s.hypothesis.name}")
        tried = refit(fit, (*fit.model.hypotheses, s.hypothesis))
        if not (dated(tried, s.hypothesis) and natural(tried, s.hypothesis)):
            continue
        out.append(Trial(s.hypothesis, tried, log_evidence(tried) - base))
    return sorted(out, key=lambda t: -t.evidence)


def asked(tried: list[Trial]) -> list[Trial]:
    """Return the trials that held-out data are asked about, one after the other until one is not refused.

    The best, and the best without states, which a spline that takes in everything hides; with those as good as it.
    """
    plain = [t for t in tried if not t.hypothesis.effect.states]
    return [tried[0], *(t for t in plain if t is not tried[0] and t.evidence > plain[0].evidence - NEEDED)]


def dated(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect's moment, where it has one, has recording before and after it."""
    start, end = fit.span
    moments = [fit.state.values[h.key(p.name)] for p in h.effect.parameters if p.name == "time"]
    return all(bool(np.all((t > start + BESIDE) & (t < end - BESIDE))) for t in moments)


def select(nominal: Fit, say: Callable[[str], None] = lambda _: None) -> Selection:
    """Return the effects that the recording needs."""
    fit, rejected = nominal, []
    kept = [Kept(h, np.inf, Gain(0.0, 0.0, 0.0, np.zeros(1)), ()) for h in nominal.model.hypotheses]
    rng = np.random.default_rng(SEED)
    everything = candidates(nominal.model)
    while len(kept) < MOST:
        say("scoring every effect")
        taken = {h.name for h in fit.model.hypotheses}
        left = [h for h in everything if h.name not in taken]
        plain, judged = placed(fit, [h for h in left if not h.effect.states])
        scores = sorted([*score(fit, plain), *judged], key=lambda s: -s.evidence)
        tried = [t for t in plain_trials(fit, scores, say) if t.evidence > NEEDED]
        better = with_noise(tried[0].fit) if tried else fit
        if tried and (windows := blind(better, tried[0].hypothesis)):
            better, fit = with_noise(blinded(better, windows)), blinded(fit, windows)
            tried = tried[:1]  # the others were fitted to samples that no longer count
        chain = ahead(fit, better, plain, say) if tried else []
        further = chain[-1].fit if chain else better
        together: list[Trial] = []  # what comes in with the best
        if suspicious(further):
            lively = state_trials(fit, [h for h in left if h.effect.states and h.effect.variant != "isotropic"], say)
            if lively and before_plain(lively[0], fit, further):
                tried, better = lively + tried, lively[0].fit
            else:
                together = chain
        if not tried:
            break
        for best in asked(tried):
            say(f"predicting held-out data with {best.hypothesis.name}")
            better = better if best is tried[0] else with_noise(best.fit)
            won = foretold(fit, better, rng)
            if won.low > 0:
                break
            rejected.append((best.hypothesis, won.value))
        else:
            break
        for h in (best.hypothesis, *best.also):
            kept.append(Kept(h, best.evidence, won, tuple(t for t in tried if t is not best and not t.also)))
        for trial in together if best is tried[0] else []:
            won = foretold(better, trial.fit, rng)
            if won.low <= 0 or len(kept) == MOST - 1:
                break
            kept, better = [*kept, Kept(trial.hypothesis, trial.evidence, won, ())], trial.fit
        fit, kept = exchanged(better, kept, say)
    fit, kept, dropped = prune(fit, kept, say)
    flat, changed = filtered(fit, kept, say)
    if flat is not fit:
        fit, kept, more = prune(flat, changed, say)
        dropped += more
    if fit.model.tilts:
        say("settling springs and dampers")
        fit = fit_with_noise(fit.model, fit.state, fit.noise, fit.anchor, rounds=SETTLED)
    return Selection(fit, tuple(kept), (*rejected, *dropped))


def foretold(fit: Fit, better: Fit, rng: np.random.Generator) -> Gain:
    """Return what a fit with more in it gains on held-out data, both at its noise levels."""
    return predicted(at_noise_of(fit, better), better, rng)


def before_plain(lively: Trial, fit: Fit, further: Fit) -> bool:
    """Return whether an effect with states explains more than those without that made `further` of the fit."""
    plainly = log_evidence(further) - log_evidence(fit)
    return lively.evidence > max(NEEDED, plainly if lively.hypothesis.effect.lawful else TWICE * plainly)


def ahead(fit: Fit, better: Fit, plain: list[Hypothesis], say: Callable[[str], None]) -> list[Trial]:
    """Return more effects without states than the one in `better`, while each takes much of what is left before it.

    A free spline explains nearly anything, two scales of a sensor too: it is not asked while scales do. Where it is
    asked and explains less, all of these are taken: what only stood in for a spline is dropped once that is in.
    """
    out: list[Trial] = []
    for _ in range(AHEAD):
        if not suspicious(better) or misfit(better) - 1 > LITTLE * max(misfit(fit) - 1, 0.0):
            break
        say("looking whether more effects without states explain it")
        names = {h.name for h in better.model.hypotheses}
        tried = plain_trials(better, score(better, [h for h in plain if h.name not in names]), say, 1)
        if not tried or tried[0].evidence < NEEDED:
            break
        fit, better = better, with_noise(tried[0].fit)
        out.append(replace(tried[0], fit=better))
    return out


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


__all__ = [
    "NEEDED", "RELATED", "RIVALS", "SEED", "TRIED", "Kept", "Selection", "Trial", "calm", "candidates", "misfit",
    "plain_trials", "select", "state_trials", "with_noise",
]  # fmt: skip

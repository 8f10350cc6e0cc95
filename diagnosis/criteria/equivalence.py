"""What a recording cannot tell apart: effects that, in another's place, would explain it as well.

What an effect adds to the measurements is compared with what a rival can make of it once the motion, the geometry and
the other effects are free to follow. With M the information of both, the others marginalised, a the effect's own column
(its mark, as fitted), r the rival's parameters and L its prior's information, the rival would leave (M_aa - M_ar (M_rr
+ L)^-1 M_ra) / 2 nat of the effect unexplained.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.criteria import ADMISSION, EQUIVALENCE
from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.delays import filters, late_imu, left_by
from imubench.diagnosis.criteria.signatures import MARK, Columns, JointInformation, joint_information, signature
from imubench.diagnosis.noise.colour_bound import louder_where
from imubench.diagnosis.noise.coloured import Spectra, noise_spectra
from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.gauss_newton import extended, guess_of
from imubench.diagnosis.solve.refit import log_evidence, refit
from imubench.effects import EFFECTS, possible
from imubench.effects.effect import Effect


@dataclass(frozen=True)
class Rival:
    """An effect that could stand in another's place."""

    effect: str
    at: str
    loss: float  # nat, what the fit would lose
    exact: bool = False  # refitted, not only expected


@dataclass(frozen=True)
class Replacement:
    """One effect in the place of some that a fit has."""

    hypothesis: Hypothesis
    loss: float  # nat
    share: float  # of what they explain
    guess: dict[str, Array]  # its parameters


def alternatives(model: Model, h: Hypothesis) -> list[Hypothesis]:
    """Return what could stand in an effect's place: every law that is near linear, and the other clock."""
    recording = model.recording
    taken = {other.name for other in model.hypotheses}
    out = [Hypothesis(effect, at) for effect, at in possible(recording) if effect.parameters and not effect.states]
    if h.effect.between_sensors:
        out += [Hypothesis(h.effect, i.name) for i in recording.imus]
    out = [r for r in out if r.name not in taken and not r.effect.grid(1.0)]
    out.sort(key=lambda r: not shared_with(r.effect))  # first: all of them stand in for another one together
    return list({r.name: r for r in out}.values())


def rivals(fit: Fit, h: Hypothesis, sure: bool = True) -> list[Rival]:
    """Return what every other effect would lose in the place of `h`, a kept effect of the fit, the closest first.

    `sure`: the closest few are refitted exactly, for a law far from linear seems to lose more than it does.
    """
    bare, still, added = signature(fit, fit.state, [h])
    slow = late_imu(fit, h)
    stands = State(still.coefficients, fit.state.values)
    smooth = filters(bare, stands, *slow, fit.noise) if slow else {}
    both, wanted, single = _against(fit, (bare, still, added), alternatives(fit.model, h), smooth)
    found = [Rival(one.hypothesis.effect.name, one.hypothesis.at, one.loss) for one in single]
    scales = [one.hypothesis for one in single if h.effect.name in shared_with(one.hypothesis.effect)]
    if scales:
        loss, _ = both.explained(wanted, both.along(*(r.name for r in scales)).sum(axis=1, keepdims=True))
        found += [Rival(r.effect.name, r.at, loss) for r in scales]
    if slow:
        found += [Rival(n, slow[0].name, left_by(both, wanted, both.along(n)[:, 0])) for n in smooth]
    if sure:
        shown = noise_spectra(fit)
        doubt = EQUIVALENCE.dull_doubt if louder(fit, added, shown) > EQUIVALENCE.dull_level else EQUIVALENCE.doubt
        close = [one for one in single if one.loss > EVIDENCE.needed_nat and one.share < doubt][: ADMISSION.refits]
        asked = {one.hypothesis: one.guess for one in close} | elsewhere(fit, h)
        tried = [_refitted(fit, h, other, guess, shown) for other, guess in asked.items()]
        found += [t for t in tried if t is not None]
    best: dict[tuple[str, str], Rival] = {}
    for rival in sorted(found, key=lambda r: r.loss):
        best.setdefault((rival.effect, rival.at), rival)
    best.pop((h.effect.name, h.at), None)
    return sorted(best.values(), key=lambda r: r.loss)


def elsewhere(fit: Fit, h: Hypothesis) -> dict[Hypothesis, dict[str, Array]]:
    """Return a hum at the other IMUs, with its parameters at its own: a motion that is free carries it there."""
    if not h.effect.tone:
        return {}
    taken = {other.name for other in fit.model.hypotheses}
    others = [replace(h, at=i.name) for i in fit.model.recording.imus]
    keys = [p.name for p in h.effect.parameters]
    return {o: {o.key(k): fit.state.values[h.key(k)] for k in keys} for o in others if o.name not in taken}


def _refitted(
    fit: Fit, h: Hypothesis, other: Hypothesis, guess: dict[str, Array], shown: Mapping[str, Spectra]
) -> Rival | None:
    """Return what the fit, or its evidence, really loses with another effect, from a guess, in the place of `h`.

    In noise of the colour that is `shown`: what the two leave differs by a signal, and beside noise louder than white
    at its frequencies that tells so much less.
    """
    rest = tuple(kept for kept in fit.model.hypotheses if kept != h)
    try:
        tried = refit(fit, (*rest, other), guess)
    except NotPositiveDefiniteError:
        return None
    before = {r.name: r.residual.value for r in fit.rows}
    off = {r.name: r.residual.value - before[r.name] for r in tried.measured if r.name in before}
    worse = tried.cost - fit.cost
    # the evidence, because parameters of `h` that only fitted noise are no loss
    easier = min(log_evidence(fit) - log_evidence(tried) - worse, 0.0)
    lost = worse / louder(fit, off, shown) + easier
    return Rival(other.effect.name, other.at, max(lost, 0.0), exact=True)


def louder(fit: Fit, signals: Mapping[str, Array], shown: Mapping[str, Spectra]) -> float:
    """Return how much louder than white a fit's noise is where signals (n, m), in their units, have their power."""
    seen = [r for r in fit.measured if r.name in signals]
    moved = [(r.name, r.time, signals[r.name] / r.std) for r in seen]
    return louder_where(moved, shown, {}, fit.model.averaging)


def equivalents(fit: Fit, h: Hypothesis) -> list[Rival]:
    """Return what the recording cannot tell from `h`, a kept effect of the fit, the closest first."""
    found = {(r.effect, r.at): r for r in rivals(fit, h) if r.loss < EVIDENCE.needed_nat}
    same = [other for other in fit.model.hypotheses if other.effect.name == h.effect.name]
    if h in same and len(same) == len(fit.model.recording.imus):
        for name, at in shared_with(h.effect).items():
            loss = _all_of(fit, same, name, at)
            if loss < EVIDENCE.needed_nat:
                found[(name, at)] = Rival(name, at, loss)
    return sorted(found.values(), key=lambda r: r.loss)


def shared_with(effect: Effect) -> dict[str, str]:
    """Return the effects, each with its place, that an effect cannot be told from where every sensor has it."""
    return {a.effect: a.other_at for a in effect.alike if a.shared}


def _all_of(fit: Fit, same: Sequence[Hypothesis], name: str, at: str) -> float:
    """Return what is lost when an effect at a place stands for one that every sensor has."""
    recording = fit.model.recording
    if name not in EFFECTS or at not in EFFECTS[name].places(recording):
        return np.inf
    instead = Hypothesis(EFFECTS[name].suited(recording), at)
    if instead.name in {h.name for h in fit.model.hypotheses}:
        return np.inf
    return replacements(fit, same, [instead])[0].loss


def replacements(fit: Fit, gone: Sequence[Hypothesis], others: Sequence[Hypothesis]) -> list[Replacement]:
    """Return what each of some effects is expected to lose in the place of kept ones, the closest first."""
    return _against(fit, signature(fit, fit.state, gone), others)[2]


def _against(
    fit: Fit,
    marked: tuple[Model, State, dict[str, Array]],
    others: Sequence[Hypothesis],
    columns: Columns | None = None,
) -> tuple[JointInformation, Array, list[Replacement]]:
    """Return the information of all and of what was taken out, its direction, effects by their loss in its place."""
    bare, still, added = marked
    begun = extended(replace(fit, model=bare, state=still), (*bare.hypotheses, *others))
    both = joint_information(begun.model, begun.state, fit, others, {MARK: added} | (columns or {}))
    wanted = both.along(MARK)[:, 0]
    total = max(0.5 * float(wanted @ both.information @ wanted), 1e-9)
    out = []
    for r in others:
        loss, size = both.explained(wanted, both.along(r.name))
        start = np.concatenate([p.centre for p in r.effect.parameters])
        out.append(Replacement(r, loss, loss / total, guess_of(r, start + size)))
    return both, wanted, sorted(out, key=lambda one: one.loss)


__all__ = ["Replacement", "Rival", "alternatives", "equivalents", "replacements", "rivals"]

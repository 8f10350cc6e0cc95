"""What a selection found, in the words of diagnosis.json."""

import numpy as np

from imubench.diagnosis.candidates.both_mounts import gives_way
from imubench.diagnosis.config.criteria import ADMISSION
from imubench.diagnosis.config.shared import CONFIDENCE, EVIDENCE
from imubench.diagnosis.config.verdict import FINDINGS
from imubench.diagnosis.criteria.equivalence import Rival, equivalents
from imubench.diagnosis.criteria.trial import Kept, Passed
from imubench.diagnosis.experiments.design import separation
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.intervals import with_spring_intervals
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.excess_noise import left_over
from imubench.diagnosis.residual_checks.implausible import implausible_places
from imubench.diagnosis.result import Finding, Interval, Rejected
from imubench.diagnosis.search.confidence import MOST_SURE, confidence
from imubench.diagnosis.search.selected import Selection
from imubench.diagnosis.solve.refit import information
from imubench.diagnosis.verdict.effect_parameters import parameters
from imubench.diagnosis.verdict.unobservable import seen_of, unseen_in_words, widened, with_directions
from imubench.effects import EFFECTS
from imubench.recording import Recording


def findings(selection: Selection, measured: Recording | None = None, briefly: bool = False) -> tuple[Finding, ...]:
    """Return the effects that stay, strongest first.

    `measured` is the recording as it came, where the fit's is another: what of a hum wanders is not in that. `briefly`:
    where there is no time, with the search's own numbers, and without equivalents of the same law of the recording or
    the motions that would tell them apart.
    """
    numbers = selection.fit if briefly else selection.numbers
    covariance, white = information(numbers)
    std = white if briefly else with_spring_intervals(numbers, parameter_std(numbers))
    covariance = widened(numbers, covariance, white, std)
    recording = selection.fit.model.recording
    loose, small = weakly_held(selection.fit), overshadowed(selection)
    odd = set() if gives_way(selection.fit) else implausible_places(selection.fit)  # or else that is why they are odd
    out = []
    for kept in strongest_first(selection):
        h, gain = kept.hypothesis, kept.heldout
        others = [] if briefly else equivalents(selection.fit, h)
        same = [Rejected(r.effect, r.at, gain.value - r.loss) for r in others]
        springs = laws_as_good(kept)
        same += [Rejected(t.hypothesis.effect.name, h.at, gain.value - kept.evidence + t.evidence) for t in springs]
        told = {(r.effect, r.at) for r in same}
        ties = [Rejected(t.hypothesis.effect.name, h.at, gain.value + t.evidence) for t in kept.ties]
        ties = [r for r in ties if (r.effect, r.at) not in told]
        most = (
            CONFIDENCE.doubtful
            if springs
            else CONFIDENCE.doubtful
            if h in small
            else CONFIDENCE.free_splines
            if h in loose
            else MOST_SURE
        )
        most = CONFIDENCE.strange if h.at in odd else most
        out.append(
            Finding(
                h.effect.name,
                h.at,
                min(confidence(kept.evidence, EVIDENCE.needed_nat), most),
                with_directions(parameters(h, numbers, std, measured), seen := seen_of(numbers, h, covariance)),
                Interval(gain.value, (gain.low, gain.high)),
                (*same, *ties),
                "" if briefly else separation(selection.fit, h, [_rival(r, recording) for r in others]),
                unseen=unseen_in_words(numbers, h, seen),
            )
        )
    return tuple(out)


def _rival(r: Rival, recording: Recording) -> Hypothesis:
    return Hypothesis(EFFECTS[r.effect].suited(recording), r.at)


def laws_as_good(kept: Kept) -> list[Passed]:
    """Return the other laws of its IMU that were worth as much as the kept one: soft springs for rocking ones."""
    h = kept.hypothesis
    laws = [t for t in kept.rivals if t.hypothesis.effect.lawful and t.hypothesis.at == h.at and t.evidence > kept.near]
    return [t for t in laws if h.effect.lawful and t.hypothesis.effect.name != h.effect.name]


def overshadowed(selection: Selection) -> list[Hypothesis]:
    """Return the effects beside a stronger one that are worth next to nothing of what all together leave of the noise.

    What is wrong in a model is made up for by whatever is at hand: beside an effect that no name explains, weak names
    explain small parts of it. The strongest stands by itself.
    """
    left = left_over(selection.fit, 1.0)
    weaker = strongest_first(selection)[1:]
    return [k.hypothesis for k in weaker if (k.heldout.value or k.evidence) < FINDINGS.much * left]


def strongest_first(selection: Selection) -> list[Kept]:
    """Return the effects that stay by what they gain on held-out data."""
    return sorted(selection.kept, key=lambda k: -k.heldout.value)


def weakly_held(fit: Fit) -> list[Hypothesis]:
    """Return the effects of a fit whose states are held by no law, or by one beside which too much is left."""
    lawful = misfit(fit) <= ADMISSION.unexplained_misfit
    return [h for h in fit.model.hypotheses if h.effect.states and not (h.effect.lawful and lawful)]


def rejected(selection: Selection) -> tuple[Rejected, ...]:
    """Return what was tried and not kept, with what it gains in nat."""
    kept = {k.hypothesis.name for k in selection.kept}
    lost = {(h.effect.name, h.at): v for h, v in selection.rejected if h.effect.name in EFFECTS}
    for k in selection.kept:
        for t in k.rivals:
            if t.hypothesis.name not in kept and np.isfinite(t.evidence):  # the nominal fit's clock was never judged
                lost.setdefault((t.hypothesis.effect.name, t.hypothesis.at), t.evidence - k.evidence)
    return tuple(Rejected(name, at, float(v)) for (name, at), v in lost.items())


__all__ = ["findings", "laws_as_good", "overshadowed", "rejected"]

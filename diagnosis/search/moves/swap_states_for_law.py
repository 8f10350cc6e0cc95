"""An effect whose states follow a law, and plain effects beside it, in the place of states without one.

A pivot that moves as it likes explains whatever a lone IMU reads on a limb: what a filter holds back, and a scale and a
bias beside it. One effect with a law is then worth less than that, and each of the plain ones little.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.conditional_aic import aic_gain
from imubench.diagnosis.criteria.trial import Trial
from imubench.diagnosis.noise.declared_noise import misfit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.dynamic_refits import on_whole_recording
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.diagnosis.solve.refit import evidence_over

NextPlain = Callable[[Fit, Sequence[Hypothesis], Callable[[str], None]], Trial | None]
"""What returns the best effect without states beside a fit, of some, or None where none is needed."""

MOST_RIVALS = 2  # effects with a law that are asked, those that leave least
MOST_BESIDE = 3  # plain effects at most beside one
AS_MUCH = 1.1  # times the misfit that is left beside states without a law, which follow all that one with a law does


def states_to_law(
    fit: Fit,
    further: Fit,
    lively: Sequence[Trial],
    plain: Sequence[Hypothesis],
    say: Callable[[str], None],
    next_plain: NextPlain,
) -> list[Trial] | None:
    """Return an effect with a law and those beside it, in their order, that are worth more than states without one.

    None where the first of `lively` has a law itself, or is worth no more than the plain effects that made `further` of
    the fit. None either where nothing together is worth as much and leaves as little: effects that gain more and still
    leave several times the noise are not what the states without a law have explained.
    """
    if not lively or lively[0].hypothesis.effect.lawful or lively[0].evidence <= evidence_over(fit, further):
        return None
    name = lively[0].hypothesis.effect.name  # itself on springs is no other effect: creep was a play on springs, surely
    other = [t for t in lively if t.hypothesis.effect.lawful and t.hypothesis.effect.name != name]
    rivals = sorted(other, key=lambda t: misfit(t.fit))
    for t in rivals[:MOST_RIVALS]:
        whole = on_all(fit, t)
        way = beside(whole, plain, say, next_plain) if whole is not None else []
        as_little = bool(way) and misfit(way[-1].fit) < AS_MUCH * misfit(lively[0].fit)
        if as_little and aic_gain(fit, way[-1].fit) > lively[0].evidence + EVIDENCE.needed_nat:
            return way
    return None


def on_all(fit: Fit, trial: Trial) -> Trial | None:
    """Return a trial on the whole recording, where it was made on a part; None where there it is none."""
    if trial.fit.span == fit.span:
        return trial
    with suppress(NotPositiveDefiniteError):
        return on_whole_recording(fit, trial)
    return None


def beside(trial: Trial, plain: Sequence[Hypothesis], say: Callable[[str], None], next_plain: NextPlain) -> list[Trial]:
    """Return a trial and what evidence asks for beside it, of effects without states, one after the other."""
    say(f"looking for more beside {trial.hypothesis.name}")
    out = [replace(trial, fit=with_noise(trial.fit))]
    for _ in range(MOST_BESIDE):
        found = next_plain(out[-1].fit, plain, say)
        if found is None:
            break
        out.append(found)
    return out


__all__ = ["states_to_law"]

"""A rival that was as good when it was passed over may be the better one beside what came later.

One of more numbers may also do what two of few do, before the second of these has come in: the nine of a g-sensitivity
took the place of a gyroscope's bias, 45 bounds of whose drift were to come. So it is held against both.
"""

from collections.abc import Callable, Sequence

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.criteria.trial import Kept, Passed
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.add import plain_scores, plain_trials
from imubench.diagnosis.solve.levenberg_marquardt import Fit
from imubench.diagnosis.solve.refit import log_evidence, refit

TIE, SHARE = 20.0, 0.05  # nat, or of the evidence, within which two effects were as good


def swapped_for_rivals(
    fit: Fit, kept: list[Kept], everything: Sequence[Hypothesis], say: Callable[[str], None]
) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, each changed for the rival of its round that is now worth more.

    Not where one of `everything` beside it is worth more still, with no more numbers together.
    """
    if len(kept) < 2:
        return fit, kept
    out = []
    for k in kept:
        taken = {h.name for h in fit.model.hypotheses}
        near = [t for t in k.rivals if t.evidence > k.evidence - max(TIE, SHARE * k.evidence)]
        for t in [t for t in near if t.hypothesis.name not in taken and not t.hypothesis.effect.states][:1]:
            say(f"trying {t.hypothesis.name} in the place of {k.hypothesis.name}")
            names = tuple(t.hypothesis if h == k.hypothesis else h for h in fit.model.hypotheses)
            tried = refit(fit, names)
            more = log_evidence(tried) - log_evidence(fit)
            further = t.hypothesis.effect.numbers - k.hypothesis.effect.numbers
            if more > EVIDENCE.needed_nat and more > beside(fit, further, everything, say):
                fit = with_noise(tried)
                k = Kept(t.hypothesis, k.evidence, k.heldout, (Passed(k.hypothesis, k.evidence - EVIDENCE.needed_nat),))
        out.append(k)
    return fit, out


def beside(fit: Fit, most: int, everything: Sequence[Hypothesis], say: Callable[[str], None]) -> float:
    """Return the nat that the best effect without states is worth beside a fit's, of at most so many numbers."""
    taken = {h.name for h in fit.model.hypotheses}
    few = [h for h in everything if h.name not in taken and 0 < h.effect.numbers <= most]
    tried = plain_trials(fit, plain_scores(fit, few)[1], say, 1) if few else []
    return tried[0].evidence if tried else 0.0

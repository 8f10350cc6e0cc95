"""A rival that was as good when it was passed over may be the better one beside what came later."""

from collections.abc import Callable

from imubench.diagnosis.fit import Fit
from imubench.diagnosis.noise import with_noise
from imubench.diagnosis.refit import log_evidence, refit
from imubench.diagnosis.trial import NEEDED, Kept, Passed

TIE, SHARE = 20.0, 0.05  # nat, or of the evidence, within which two effects were as good


def exchanged(fit: Fit, kept: list[Kept], say: Callable[[str], None]) -> tuple[Fit, list[Kept]]:
    """Return the fit and its effects, each changed for the rival of its round that is now worth more."""
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
            if log_evidence(tried) > log_evidence(fit) + NEEDED:
                fit = with_noise(tried)
                k = Kept(t.hypothesis, k.evidence, k.heldout, (Passed(k.hypothesis, k.evidence - NEEDED),))
        out.append(k)
    return fit, out

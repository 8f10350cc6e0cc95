"""Names that may be what a finding without one is: as far as the recording tells, its equals."""

from collections.abc import Collection, Sequence

from imubench.diagnosis.config.shared import EVIDENCE
from imubench.diagnosis.result import Finding, Rejected


def with_equivalents(rest: Sequence[Finding], named: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings without a name; those that a name equals are equalled by what the recording cannot tell from it.

    Equivalence is handed on: what equals a name that equals the finding cannot be told from the finding either.
    """

    def likes(u: Finding) -> list[Rejected]:
        equal = {(r.effect, r.at) for r in u.equivalent}
        return [r for f in named if (f.effect, f.at) in equal for r in f.equivalent]

    return tuple(u.equalled_by(likes(u)) for u in rest)


def with_refused_equivalents(
    rest: Sequence[Finding], named: Sequence[Finding], refused: Collection[Rejected]
) -> tuple[Finding, ...]:
    """Return findings without a name, each equalled by what was refused at its place and gained as much as it does.

    What a sensor reads a little later can take the place of a refused rocking mount. A name that is found after all is
    no equal: it stands beside.
    """
    found = {(f.effect, f.at) for f in named}
    names = [r for r in refused if (r.effect, r.at) not in found]

    def as_good(u: Finding) -> list[Rejected]:
        least = max(u.heldout_gain.value - EVIDENCE.needed_nat, EVIDENCE.needed_nat)
        return [r for r in names if r.at == u.at and r.heldout_gain > least]

    return tuple(u.equalled_by(as_good(u)) for u in rest)


__all__ = ["with_equivalents", "with_refused_equivalents"]

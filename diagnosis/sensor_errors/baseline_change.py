"""What one diagnosis says that another of the same sensors does not: findings of its own, and numbers that changed."""

from dataclasses import replace

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.result import Finding, Parameter
from imubench.effects import traits_of
from imubench.effects.effect import Change


def differ(finding: Finding, own: Finding, change: Change | None = None) -> bool:
    """Return whether two findings of one name and place have a number that is surely not the same.

    Args:
        finding: of the later recording.
        own: of the earlier one.
        change: how far its numbers go from one recording to the next anyhow.
    """
    return any(
        bool(np.any(np.abs(p.value - q.value) > STATISTICS.clear_sigmas * np.hypot(spread(p, q), allowed(q, change))))
        for p, q in shared(finding, own).values()
        if p.value.shape == q.value.shape
    )


def changed(finding: Finding, own: Finding) -> Finding:
    """Return a finding with its numbers less those of the earlier recording's, where such errors add up."""
    if not traits_of(finding.effect).additive:
        return finding
    pairs = shared(finding, own).items()
    less = {name: Parameter(p.value - q.value, spread(p, q), p.unit) for name, (p, q) in pairs}
    return replace(finding, parameters={**finding.parameters, **less})


def shared(finding: Finding, own: Finding) -> dict[str, tuple[Parameter, Parameter]]:
    """Return the parameters that two findings both have."""
    return {n: (p, own.parameters[n]) for n, p in finding.parameters.items() if n in own.parameters}


def spread(one: Parameter, other: Parameter) -> Array:
    """Return the standard deviation of the difference of two numbers that were found apart."""
    return np.asarray(np.hypot(one.std, other.std))


def allowed(own: Parameter, change: Change | None) -> Array:
    """Return how far a parameter's numbers go from one recording to the next anyhow."""
    return (change or Change()).of(own.value)


__all__ = ["allowed", "changed", "differ", "shared"]

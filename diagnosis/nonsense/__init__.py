"""What is looked for before any fit: recordings that no simulation of their rig can be held against.

A check is a function that yields a `Nonsense` for everything that it finds wrong. The first group that finds something
ends the diagnosis: what comes after would be judged on readings that mean something else.
"""

from collections.abc import Callable, Iterator

from imubench.diagnosis.nonsense.different_motions import different_motions
from imubench.diagnosis.nonsense.mirrored import mirrored
from imubench.diagnosis.nonsense.stuck import stuck
from imubench.diagnosis.nonsense.swapped import swapped
from imubench.diagnosis.nonsense.too_few_samples import too_few_samples
from imubench.diagnosis.result import Nonsense
from imubench.recording import Recording

Check = Callable[[Recording], Iterator[Nonsense]]

CHECKS: tuple[tuple[Check, ...], ...] = ((too_few_samples,), (stuck,), (mirrored, different_motions), (swapped,))


def nonsense(recording: Recording) -> tuple[Nonsense, ...]:
    """Return what is wrong with a recording from the ground up; empty for one that can be diagnosed."""
    for group in CHECKS:
        if found := tuple(n for check in group for n in check(recording)):
            return found
    return ()


__all__ = ["CHECKS", "Check", "nonsense"]

"""What a move is: it proposes other states of the search, and the loop decides which are taken.

A move is a generator. It yields one proposal after the other, and is answered each time with what was decided and the
state that the search has then: `answer = yield Proposal(...)`. So a move asks for what is expensive only where what
came before it did not settle the matter, and never compares a gain with what is needed itself.
"""

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.criteria.trial import Gain, Kept, Trial
from imubench.diagnosis.noise.masking import Masks
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.rules import RuleUse, Tested

Refused = tuple[tuple[Hypothesis, float], ...]
"""Effects with the nat that they gained on left-out data, or what they were worth where that was enough."""

Promises = dict[str, list[float]]
"""What effects with states promised, in nat by name, each time that they were refitted for nothing."""


@dataclass(frozen=True)
class Round:
    """What a round of adding has tried."""

    fit: Fit  # without it, on the samples that count
    tried: list[Trial]  # the one that explains most first
    first: Fit  # with that one, at the noise levels that it leaves
    together: list[Trial]  # what comes in with it, one after the other
    lively: bool  # whether effects with states were looked at
    brief: bool = False  # whether the first one shows in a moment, as its law says
    plain: Sequence[Hypothesis] = ()  # effects without states, at their starts


@dataclass(frozen=True)
class RoundMemory:
    """What the rounds of adding effects hand on from one to the next."""

    again: bool = True  # whether there is to be another one
    asked: tuple[Hypothesis, ...] | None = None  # what it asks; None: everything that may come in
    before: int = 0  # effects that were kept before the last one
    came: bool = False  # whether something came in with the last one
    late: bool = False  # whether a clock's offset came in with it
    heard: frozenset[str] = frozenset()  # filters that were worth much in a round, whatever came in instead
    vain: Promises = field(default_factory=dict)  # written to by `state_trials`


@dataclass(frozen=True)
class SearchState:
    """All that the search knows at one moment."""

    fit: Fit  # the motion with the effects that are kept
    kept: tuple[Kept, ...]
    everything: tuple[Hypothesis, ...] = ()  # what may come in, and what is in
    refused: Refused = ()  # on left-out data, or with it
    dropped: Refused = ()  # what was in, and was not needed
    firm: tuple[Hypothesis, ...] = ()  # effects that the noise's colour was not, before the knots became finer
    weighed: Fit | None = None  # the fit of which it was last asked what it can do without
    rounding: Mapping[str, float] = field(default_factory=dict)  # nat that a state may gain of it, by place
    rounds: RoundMemory = field(default_factory=RoundMemory)
    sound: Masks | None = None  # samples that count beside no effect; None: all
    not_tried: tuple[str, ...] = ()  # stages of the search that the time limit did not allow
    random: np.random.Generator = field(
        default_factory=lambda: np.random.default_rng(STATISTICS.seed)
    )  # of the bootstraps
    use: RuleUse = field(default_factory=RuleUse)

    @property
    def names(self) -> set[str]:
        """The names of the effects in the fit."""
        return {h.name for h in self.fit.model.hypotheses}

    @property
    def came(self) -> tuple[Kept, ...]:
        """The effects that came in with the last round of adding."""
        return self.kept[self.rounds.before :]

    def changed(self, fit: Fit, kept: Sequence[Kept]) -> "SearchState":
        """Return the state with another fit and its effects."""
        return replace(self, fit=fit, kept=tuple(kept))

    def without(self, gone: Refused, fit: Fit) -> "SearchState":
        """Return the state with a fit without some effects, which were dropped."""
        names = {h for h, _ in gone}
        kept = tuple(k for k in self.kept if k.hypothesis not in names)
        return replace(self, fit=fit, kept=kept, dropped=(*self.dropped, *gone))


@dataclass(frozen=True)
class Above:
    """A test: a number is above a bound, or at least at it."""

    measure: Callable[[], float]  # nat
    bound: float
    reached: bool = False  # whether the bound itself is enough


@dataclass(frozen=True)
class Holds:
    """A test: something is true of the new fit, as that its numbers are such as nature knows."""

    condition: Callable[[], bool]


@dataclass(frozen=True)
class Foretells:
    """A test: the new fit predicts data that it has not seen."""

    gain: Callable[[], Gain]
    least: float = 0.0  # nat
    halves: Callable[[], Gain] | None = None  # the gain by halves, asked where a block is too short for the effect
    worth: float = 0.0  # nat of the whole recording: blocks that cannot have gained as much are too short
    anyway: bool = False  # True: what is gained is noted, and not asked for


@dataclass(frozen=True)
class Proposal:
    """Another state of the search, and what it must show to be taken."""

    what: str  # as one reads it: `low_pass@imu2 in the place of time_offset@imu2`
    after: SearchState | Callable[[Gain | None], SearchState]  # or what makes it, of the gain on left-out data
    tests: Sequence[Above | Holds | Foretells] = ()  # in their order; the first that fails ends it
    otherwise: SearchState | None = None  # what is known where it is refused; None: as before


@dataclass(frozen=True)
class Answer:
    """What was decided about a proposal."""

    accepted: bool
    state: SearchState  # of the search, from here on
    gain: Gain | None  # on left-out data, where that was asked
    tests: tuple[Tested, ...] = ()  # that were asked


def told(gain: Gain | None) -> Gain:
    """Return what is gained on left-out data.

    Raises:
        ValueError: where no test of the proposal asked for it.
    """
    if gain is None:
        raise ValueError("expected a gain on left-out data; no test of this proposal asks for it")
    return gain


Proposals = Generator[Proposal, Answer, None]


class Move(Protocol):
    """A way from one state of the search to others."""

    def propose(self, state: SearchState) -> Proposals:
        """Yield proposals, each after the answer to the one before; the answer has the state to go on from."""


@dataclass(frozen=True)
class Step:
    """A move that is always taken: a state computed from the one before, as noise levels that settle.

    It changes nothing where it returns the state that it was given.
    """

    what: str
    step: Callable[[SearchState], SearchState]

    def propose(self, state: SearchState) -> Proposals:
        """Yield the one state that follows, if it is another."""
        after = self.step(state)
        if after is not state:
            yield Proposal(self.what, after)


__all__ = [
    "Above", "Answer", "Foretells", "Holds", "Move", "Promises", "Proposal", "Proposals", "Refused", "Round",
    "RoundMemory", "SearchState", "Step", "told",
]  # fmt: skip

"""The rules of a diagnosis by name: what each does, which are switched off, and which changed anything."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from imubench.errors import unknown

T = TypeVar("T")

RULES: Mapping[str, str] = {
    # the search, in the order of its table
    "backlash-for-clocks": "put backlash in the place of every clock's offset, if that is worth more",
    "quick-filter-for-clock": "put a filter far quicker than the motion in the place of a clock's offset",
    "add": "add the effects that explain most and gain on left-out data",
    "rival-for-effect": "put a rival that was as good when it was passed over in the place of an effect",
    "filter-of-one-triple": "put a filter of one triple and a second effect in the place of a filter of both",
    "friction-mixture": "choose among all mixtures of the laws of friction",
    "finer-knots": "fit on as many knots as what was found asks for",
    "drop": "drop effects that the fit can do without",
    "rounded-states": "drop state effects that gain no more than rounding may have",
    "merge": "put one effect in the place of two",
    "filter-for-clock": "put a filter with states in the place of a clock's offset",
    "settle-laws": "estimate the noise of springs' and filters' laws to the end",
    "mask-moments": "let the moments in which effects act count as much as they tell",
    "converge": "solve the last fit to the end",
    "friction-together": "judge several laws of friction on left-out data together",
    # what has no name, held against what has one
    "law-for-series": "put a filter or a spring in the place of a series without a name",
    "effect-for-term": "put an effect of fitting size in the place of something without a name",
    "nonlinear-springs": "say springs that bend, and doubt those that may",
    "term-for-effects": "put a term without a name in the place of effects that it explains more than",
    "add-term": "add the term without a name that explains most, while one does",
    "suspected-springs": "say soft mounts that likely bend as something without a name",
    "springs-leave-much": "say what springs leave, where that is more than noise, as something without a name",
    "off-its-equation": "say a swing that does not follow its equation as something without a name",
    "excess-noise": "say noise above the declared level",
    "negligible-names": "doubt names that are worth less than what the fit leaves",
    "equal-to-term": "say which effects explain as much as something without a name",
    # what is said of it all
    "told-by-samples": "say nothing without a name where the samples have told it",
    "like-unknown": "say which names something without one is like",
    "refused-as-equal": "say which refused effects something without a name may be",
    "doubt-beside-unknown": "doubt names beside something without one that is worth as much",
    "knocks-that-samples-doubt": "hold knocks that the raw samples doubt against the fit",
    "knocks-of-play": "count knocks of a joint's play and of an end stop as theirs",
    "doubt-beside-rounding": "doubt motions of a sensor that rounding may be",
    "left-beside-sure": "say what is left as something without a name, where a finding is sure",
    "halves-disagree": "say where the halves of a recording disagree about the model",
    # inside a round of the search
    "quiet-where-uncertain": "score beside lower noise levels, where a level is uncertain",
    "mask-beside-best": "leave out the moment of the best effect of a round",
    "moment-tells": "accept an effect that shows in a moment as its law says",
    "plain-ahead": "take several effects without states before one with states",
    "own-law-of-reading": "look for no moving sensor where a law of the reading itself explains the rest",
    "free-beside-springs": "ask splines without a law too, where springs explain much",
    "akin-for-best": "accept the best effect of a round where one akin to it gains on left-out data",
    "halves-for-blocks": "ask the recording's halves where blocks are too short to show an effect",
    "add-together": "accept several effects together that were refused one by one",
    "clock-beside-best": "ask a clock's error beside the best effect, where both explain much",
}
"""Each rule's name, and what it does."""


@dataclass(frozen=True)
class Rules:
    """Which rules a diagnosis does without; none, unless somebody asks what a rule is good for.

    Raises:
        InputError: for a name that is not in `RULES`.
    """

    off: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        object.__setattr__(self, "off", frozenset(self.off))
        for name in sorted(self.off):
            known(name)


@dataclass(frozen=True)
class Tested:
    """A test of one proposal of the search."""

    passed: bool
    met: str  # as `7.25 nat, needed 5`
    place: str  # file and line of what it asks


@dataclass(frozen=True)
class Decision:
    """What was decided about one proposal of the search."""

    rule: str
    what: str  # as `low_pass@imu2 in the place of time_offset@imu2`
    accepted: bool
    tests: tuple[Tested, ...] = ()  # in their order, up to the first that failed


@dataclass(frozen=True)
class RuleUse:
    """The rules of one diagnosis, how often each changed something in it, and what the search decided."""

    rules: Rules = field(default_factory=Rules)
    fired: Counter[str] = field(default_factory=Counter)
    decisions: list[Decision] = field(default_factory=list)  # in their order

    def begin_again(self) -> None:
        """Forget what was: the diagnosis begins anew."""
        self.fired.clear()
        self.decisions.clear()

    def on(self, name: str) -> bool:
        """Return whether a rule may be applied."""
        return known(name) not in self.rules.off

    def those(self, name: str, find: Callable[[], list[T]]) -> list[T]:
        """Return what a rule finds, which changes something where it is not empty; nothing where the rule is off."""
        found = find() if self.on(name) else []
        if found:
            self.fires(name)
        return found

    def changed(self, name: str, value: T, change: Callable[[T], T]) -> T:
        """Return what a rule makes of a value; the value itself where the rule is off.

        What has the same representation is taken to be the same: values hold arrays, which have no single truth value.
        """
        if not self.on(name):
            return value
        after = change(value)
        if after is not value and repr(after) != repr(value):
            self.fires(name)
        return after

    def fires(self, name: str) -> None:
        """Note that a rule has changed something."""
        self.fired[known(name)] += 1

    def holds(self, name: str, condition: Callable[[], bool]) -> bool:
        """Return whether a rule's condition holds, which then changes something; False where the rule is off."""
        found = self.on(name) and condition()
        if found:
            self.fires(name)
        return found


def used(rules: Rules | RuleUse | None) -> RuleUse:
    """Return the use of rules by one diagnosis: all of them for None, what is given where it is one already."""
    return rules if isinstance(rules, RuleUse) else RuleUse(rules or Rules())


def known(name: str) -> str:
    """Return a rule's name.

    Raises:
        InputError: for one that is not in `RULES`.
    """
    if name not in RULES:
        raise unknown("rule", name, RULES)
    return name


__all__ = ["RULES", "Decision", "RuleUse", "Rules", "known", "used"]

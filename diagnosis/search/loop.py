"""The search: stage by stage and rule by rule, what a move proposes is decided here and nowhere else."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from inspect import unwrap
from pathlib import Path

from imubench.diagnosis.budget import OutOfTime, check
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.rules import Decision, Tested, known
from imubench.diagnosis.search.moves.move import Above, Answer, Foretells, Holds, Move, Proposal, SearchState
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError


def always(_: SearchState) -> bool:
    """Return that a rule is asked whatever the state."""
    return True


@dataclass(frozen=True)
class Rule:
    """A move under the name by which it can be switched off."""

    name: str  # of `RULES`
    move: Move
    when: Callable[[SearchState], bool] = always

    def __post_init__(self) -> None:
        known(self.name)


@dataclass(frozen=True)
class Repeat:
    """Rules that are asked again and again, as long as there is to be another round and the last one did something."""

    rules: tuple[Rule, ...]
    again: Callable[[SearchState], bool]


@dataclass(frozen=True)
class Stage:
    """Rules in their order, under the name that is said where the time limit did not allow them."""

    name: str
    rules: tuple[Rule | Repeat, ...]


def search(state: SearchState, stages: Sequence[Stage]) -> SearchState:
    """Return the state after all stages; where the time limit stops it, the last one, with what was not tried."""
    return Search(state).through(stages)


class Search:
    """A search under way. Whenever time is up, its last state stands."""

    def __init__(self, state: SearchState) -> None:
        """Begin with a state."""
        self.state = state

    def through(self, stages: Sequence[Stage]) -> SearchState:
        """Return the state after some stages, with those that the time limit did not allow."""
        left = [stage.name for stage in stages]
        with suppress(OutOfTime):
            for stage in stages:
                check()
                self.apply(stage.rules)
                left.remove(stage.name)
        return replace(self.state, not_tried=tuple(left))

    def apply(self, rules: Sequence[Rule | Repeat]) -> None:
        """Ask some rules in their order, but those that are switched off or that the state gives no reason to ask."""
        for rule in rules:
            if isinstance(rule, Repeat):
                self.repeat(rule)
            elif self.state.use.on(rule.name) and rule.when(self.state):
                self.ask(rule)

    def repeat(self, rounds: Repeat) -> None:
        """Ask some rules round by round."""
        before = None
        while rounds.again(self.state) and self.state is not before:
            before = self.state
            self.apply(rounds.rules)

    def ask(self, rule: Rule) -> None:
        """Decide each proposal of a rule's move, answer it, and note where the rule changed something."""
        proposals = rule.move.propose(self.state)
        proposal = next(proposals, None)
        while proposal is not None:
            before, answer = self.state, decided(proposal, self.state)
            self.state = answer.state
            if proposal.tests:
                before.use.decisions.append(Decision(rule.name, proposal.what, answer.accepted, answer.tests))
            if answer.state.fit is not before.fit or (answer.accepted and answer.state.kept is not before.kept):
                before.use.fires(rule.name)
            try:
                proposal = proposals.send(answer)
            except StopIteration:
                return


def decided(proposal: Proposal, state: SearchState) -> Answer:
    """Return whether a proposal is taken: every test is passed, and the equations can be solved."""
    gain, tests = None, []
    try:
        for test in proposal.tests:
            tested, gain = outcome(test, gain)
            tests.append(tested)
            if not tested.passed:
                break
        else:
            after = proposal.after if isinstance(proposal.after, SearchState) else proposal.after(gain)
            return Answer(True, after, gain, tuple(tests))
    except NotPositiveDefiniteError:
        tests.append(Tested(False, "the equations cannot be solved", ""))
    return Answer(False, proposal.otherwise or state, gain, tuple(tests))


def outcome(test: Above | Holds | Foretells, gain: Gain | None) -> tuple[Tested, Gain | None]:
    """Return what a test has met, and the gain on left-out data that is known by then."""
    if isinstance(test, Above):
        value = test.measure()
        passed = value > test.bound or (test.reached and value == test.bound)
        return Tested(passed, f"{value:.4g} nat, needed {test.bound:.4g}", place(test.measure)), gain
    if isinstance(test, Holds):
        passed = test.condition()
        return Tested(passed, "a condition", place(test.condition)), gain
    gain = test.gain()
    foretold = gain.is_sure(test.least)
    if not foretold and test.halves is not None and gain.high < test.worth:
        gain = test.halves()
        foretold = gain.clear()
    met = f"{gain.value:.4g} nat on left-out data, 95 % {gain.low:.4g} to {gain.high:.4g}"
    noted = ", noted only" if test.anyway else ""
    return Tested(foretold or test.anyway, f"{met}{noted}", place(test.gain)), gain


def place(asked: Callable[[], object]) -> str:
    """Return the file and line that a test was written in."""
    code = getattr(unwrap(asked), "__code__", None)
    return f"{'/'.join(Path(code.co_filename).parts[-2:])}:{code.co_firstlineno}" if code else ""


__all__ = ["Repeat", "Rule", "Stage", "always", "decided", "search"]

"""The search's loop on toy moves: what it takes, what it answers, when it ends, and what a switch does."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from imubench.diagnosis.budget import OutOfTime
from imubench.diagnosis.criteria.trial import Gain, Kept
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.rules import RULES, Rules, RuleUse
from imubench.diagnosis.search.loop import Repeat, Rule, Stage, search
from imubench.diagnosis.search.moves.move import Above, Foretells, Holds, Proposal, SearchState, Step, told
from imubench.diagnosis.search.selection import STAGES
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.effects import EFFECTS
from imubench.errors import InputError

BIAS, SCALE, DRIFT = (Hypothesis(EFFECTS[name], "imu1") for name in ("gyro_bias", "gyro_scale", "gyro_drift"))
SURE, UNSURE = (Gain(50.0, low, 90.0, np.array([25.0, 25.0, loss])) for low, loss in ((20.0, 0.0), (-40.0, -45.0)))


def begun(*off):
    """A state whose fit is a number, for moves that count."""
    return SearchState(0, (), use=RuleUse(Rules(frozenset(off))))


@dataclass(frozen=True)
class Toy:
    """A move that proposes an effect for each of some tests, and the next whatever came of the one before."""

    h: Hypothesis
    tests: tuple
    heard: list

    def propose(self, state):
        new = Kept.unjudged(self.h)
        for test in self.tests:
            answer = yield Proposal(
                self.h.name,
                lambda gain, s=state: s.changed(s.fit + 1, [*s.kept, replace(new, heldout=gain or new.heldout)]),
                (test,) if test else (),
            )
            self.heard.append((answer.accepted, answer.gain))
            state = answer.state


def asked(*tests, off=(), name="add"):
    heard = []
    state = search(begun(*off), [Stage("all", (Rule(name, Toy(BIAS, tests, heard)),))])
    return state, heard


def unsolvable():
    raise NotPositiveDefiniteError


def out_of_time():
    raise OutOfTime


@pytest.mark.parametrize(
    ("test", "taken"),
    [
        (None, True),
        (Above(lambda: 5.1, 5.0), True),
        (Above(lambda: 5.0, 5.0), False),
        (Above(lambda: 5.0, 5.0, reached=True), True),
        (Above(lambda: float("nan"), 5.0, reached=True), False),
        (Holds(lambda: True), True),
        (Holds(lambda: False), False),
        (Foretells(lambda: SURE), True),
        (Foretells(lambda: SURE, least=30.0), False),
        (Foretells(lambda: UNSURE), False),
        (Foretells(lambda: UNSURE, anyway=True), True),
        (Foretells(lambda: UNSURE, halves=lambda: SURE, worth=100.0), True),
        (Foretells(lambda: UNSURE, halves=lambda: SURE, worth=80.0), False),  # blocks are long enough to have shown it
        (Holds(unsolvable), False),  # equations that cannot be solved refuse
    ],
)
def test_each_test_decides_as_it_says(test, taken):
    state, heard = asked(test)
    assert [accepted for accepted, _ in heard] == [taken]
    assert len(state.kept) == state.fit == taken
    assert state.use.fired == ({"add": 1} if taken else {})
    assert [d.accepted for d in state.use.decisions] == ([taken] if test else [])  # what is not asked is no decision


def test_a_move_hears_what_was_decided_and_goes_on_from_there():
    state, heard = asked(Foretells(lambda: SURE), Foretells(lambda: UNSURE), Holds(lambda: True))
    assert heard == [(True, SURE), (False, UNSURE), (True, None)]
    assert state.fit == 2
    assert state.kept[0].heldout is SURE
    with pytest.raises(ValueError, match="no test of this proposal asks for it"):
        told(None)


def test_tests_are_asked_in_their_order_and_no_further_than_the_first_that_fails():
    calls = []

    def says(name, value):
        return Holds(lambda: calls.append(name) or value)

    def propose(state):
        yield Proposal("it", state, (says("cheap", True), says("dear", False), says("dearest", True)))

    move = type("M", (), {"propose": staticmethod(propose)})()
    search(begun(), [Stage("all", (Rule("add", move),))])
    assert calls == ["cheap", "dear"]


def test_what_is_known_of_a_refused_proposal_is_kept_and_is_no_change():
    known = [Kept.unjudged(DRIFT)]

    def propose(state):
        yield Proposal("it", state, (Holds(lambda: False),), otherwise=state.changed(state.fit, known))

    move = type("M", (), {"propose": staticmethod(propose)})()
    state = search(begun(), [Stage("all", (Rule("drop", move),))])
    assert state.kept == tuple(known)
    assert not state.use.fired


def count_to(most):
    return Step("one more", lambda s: replace(s, fit=s.fit + 1) if s.fit < most else s)


def test_rounds_end_where_one_changes_nothing_or_no_other_is_asked_for():
    free = Repeat((Rule("add", count_to(7)),), again=lambda _: True)
    assert search(begun(), [Stage("all", (free,))]).fit == 7
    bound = Repeat((Rule("add", count_to(7)),), again=lambda s: s.fit < 3)
    assert search(begun(), [Stage("all", (bound,))]).fit == 3
    assert search(begun("add"), [Stage("all", (free,))]).fit == 0


def test_a_rule_that_is_switched_off_changes_the_outcome_where_it_fires():
    on, _ = asked(Holds(lambda: True))
    off, heard = asked(Holds(lambda: True), off=("add",))
    assert [k.hypothesis for k in on.kept] == [BIAS]
    assert on.use.fired["add"] == 1
    assert off.kept == () and heard == [] and not off.use.fired
    assert asked(Holds(lambda: True), off=("merge",))[0].fit == on.fit  # another rule's switch is none of its


def test_a_rule_is_asked_only_where_the_state_gives_reason():
    rules = (Rule("add", count_to(9), when=lambda s: s.fit > 0), Rule("merge", count_to(9)))
    state = search(begun(), [Stage("first", rules), Stage("again", rules)])
    assert state.use.fired == {"merge": 2, "add": 1}


def test_when_time_is_up_the_last_state_stands_and_the_rest_was_not_tried():
    def late(state):
        answer = yield Proposal("in time", replace(state, fit=state.fit + 6))
        yield Proposal("too late", replace(answer.state, fit=99), (Holds(out_of_time),))

    move = type("M", (), {"propose": staticmethod(late)})()
    stages = [Stage(name, (Rule("add", m),)) for name, m in (("a", count_to(5)), ("b", move), ("c", count_to(9)))]
    state = search(begun(), stages)
    assert state.fit == 7
    assert state.not_tried == ("b", "c")


def test_names_of_rules_are_known_and_the_table_uses_no_other():
    with pytest.raises(InputError, match="unknown rule 'merg'"):
        Rules(frozenset({"merg"}))
    with pytest.raises(InputError, match="unknown rule 'more'"):
        Rule("more", count_to(1))
    used = set()
    for stage in STAGES:
        for rule in stage.rules:
            used |= {r.name for r in rule.rules} if isinstance(rule, Repeat) else {rule.name}
    assert used <= set(RULES)
    assert all(text and not text[0].isupper() for text in RULES.values())

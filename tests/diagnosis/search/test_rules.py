"""Rules of the diagnosis by name: switched off, and counted where they change something."""

import numpy as np
import pytest

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report.page import page
from imubench.diagnosis.rules import RULES, Rules, RuleUse
from imubench.diagnosis.search.selection import select
from imubench.errors import InputError
from imubench.format1 import read
from imubench.listing import known
from imubench.proof.case import make_case


def without(*off):
    return RuleUse(Rules(frozenset(off)))


def test_a_rule_that_nobody_knows_is_named_with_those_that_are_known():
    with pytest.raises(InputError, match=r"unknown rule 'mergee'.*merge"):
        Rules(frozenset({"merge", "mergee"}))
    with pytest.raises(InputError, match="unknown rule 'dropp'"):
        RuleUse().on("dropp")
    assert known()["rules"] == RULES


def test_a_condition_counts_where_it_holds_and_is_not_asked_where_its_rule_is_off():
    use, asked = without("merge"), []
    assert use.holds("drop", lambda: True)
    assert not use.holds("drop", lambda: False)
    assert not use.holds("merge", lambda: asked.append(1) or True)
    assert use.fired == {"drop": 1} and not asked


def test_what_a_rule_finds_is_empty_where_it_is_off():
    use = without("merge")
    assert use.those("drop", lambda: [1, 2]) == [1, 2]
    assert use.those("drop", lambda: []) == []
    assert use.those("merge", lambda: [1]) == []
    assert use.fired == {"drop": 1}


def test_a_change_counts_where_it_is_one():
    use, array = without("merge"), np.arange(3.0)
    assert use.changed("drop", (array,), lambda x: (x[0].copy(),)) != ()
    assert not use.fired  # another object of the same numbers
    assert use.changed("drop", (array,), lambda x: (*x, 1))[1] == 1
    assert use.changed("merge", 5, lambda x: x + 1) == 5
    assert use.fired == {"drop": 1}


def test_one_diagnosis_counts_for_itself_alone():
    first, second = RuleUse(), RuleUse()
    first.fires("drop")
    assert not second.fired


@pytest.fixture(scope="module")
def biased(tmp_path_factory):
    """A limb of 5.5 s at 40 Hz whose gyroscope has a bias."""
    folder = tmp_path_factory.mktemp("rules") / "r"
    make_case(folder, "pendulum", [("gyro_bias", "imu1")], 5, "strong", seconds=5.5, rate=40.0)
    return read(folder)[0]


@pytest.mark.long
def test_a_search_does_without_a_rule_that_is_switched_off(biased):
    fit, use = nominal_fit(biased), RuleUse()
    found = select(fit, use=use)
    assert [k.hypothesis.name for k in found.kept] == ["gyro_bias@imu1"]
    assert use.fired["add"] == 1 and "merge" not in use.fired
    assert ("add", "gyro_bias@imu1", True) in [(d.rule, d.what, d.accepted) for d in use.decisions]
    assert select(fit, use=without("add")).kept == ()
    same = select(fit, use=without("merge"))  # which did not fire
    assert [(k.hypothesis.name, k.evidence) for k in same.kept] == [(k.hypothesis.name, k.evidence) for k in found.kept]


@pytest.mark.long
def test_a_diagnosis_says_which_rules_changed_something_and_does_without_one(biased):
    found, evidence = diagnose(biased)
    assert [(f.effect, f.at) for f in found.findings] == [("gyro_bias", "imu1")]
    assert set(evidence.fired) <= set(RULES) and evidence.fired["add"] == 1
    assert RULES["add"] in page(found, evidence)
    off = frozenset({"add", "effect-for-term"})  # the second finds it too, by what has no name
    rest, shown = diagnose(biased, rules=Rules(off))
    assert all(f.effect != "gyro_bias" for f in rest.findings)
    assert not off & set(shown.fired)

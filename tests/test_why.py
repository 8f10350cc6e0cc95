"""Why a diagnosis says what it says: every proposal with its tests, and thresholds that are changed for one run."""

import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks import why
from imubench.diagnosis.config import shared
from imubench.diagnosis.criteria.trial import Gain
from imubench.diagnosis.rules import Decision
from imubench.diagnosis.search import loop
from imubench.diagnosis.search.moves.move import Above, Foretells, Holds, Proposal
from imubench.diagnosis.solve.block_tridiagonal import NotPositiveDefiniteError
from imubench.errors import InputError
from imubench.proof.case import make_case


@pytest.fixture
def not_imported(monkeypatch):
    """As where nothing has read the thresholds yet; they are as before in the end."""
    monkeypatch.setattr(shared, "EVIDENCE", shared.EVIDENCE)
    monkeypatch.delitem(sys.modules, why.DECIDES, raising=False)


def test_a_threshold_is_set_before_what_reads_it(not_imported):
    assert shared.EVIDENCE.needed_nat == 5.0
    why.set_threshold("EVIDENCE.needed_nat=50")
    assert shared.EVIDENCE.needed_nat == 50.0


def test_a_threshold_that_has_been_read_is_not_set(monkeypatch):
    monkeypatch.setitem(sys.modules, why.DECIDES, SimpleNamespace())
    with pytest.raises(RuntimeError, match="before the diagnosis is imported"):
        why.set_threshold("EVIDENCE.needed_nat=50")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("EVIDENCE", "expected RECORD.FIELD=VALUE, as EVIDENCE.needed_nat=50"),
        ("EVIDENC.needed_nat=50", "unknown record of --set 'EVIDENC'"),
        ("EVIDENCE.needed=50", "unknown threshold of EVIDENCE 'needed'; known: needed_nat"),
        ("EVIDENCE.needed_nat=much", "expected a value like 5.0, got 'much'"),
        ("EVIDENCE.needed_nat=(1, 2)", "expected a value like 5.0"),
    ],
)
def test_what_is_no_threshold_is_said_in_a_line(not_imported, text, message):
    with pytest.raises(InputError) as raised:
        why.set_threshold(text)
    assert message in str(raised.value)
    assert "\n" not in str(raised.value)


def decided(*tests):
    state, after = SimpleNamespace(), SimpleNamespace()
    answer = loop.decided(Proposal("gyro_bias@imu1", lambda _: after, tests), state)
    return list(why.lines_of([Decision("add", "gyro_bias@imu1", answer.accepted, answer.tests)])), answer


def test_every_test_of_a_proposal_is_told_with_what_it_met():
    gain = Gain(40.0, 30.0, 50.0, np.full(8, 5.0))
    said, answer = decided(Above(lambda: 7.25, 5.0), Foretells(lambda: gain))
    assert answer.accepted and answer.gain is gain
    assert said[0] == "  taken: gyro_bias@imu1 (by the rule add)"
    assert "passed: 7.25 nat, needed 5 (tests/test_why.py:" in said[1]
    assert "passed: 40 nat on left-out data, 95 % 30 to 50" in said[2]


def test_the_test_that_refused_is_the_last():
    said, answer = decided(Holds(lambda: True), Above(lambda: 4.0, 5.0), Above(lambda: 9.0, 5.0))
    assert not answer.accepted
    assert said[0] == "  refused: gyro_bias@imu1 (by the rule add)"
    assert [line.split(":")[0].strip() for line in said[1:]] == ["passed", "failed"]


def unsolvable():
    raise NotPositiveDefiniteError


def test_equations_that_cannot_be_solved_refuse_and_are_told():
    said, answer = decided(Holds(lambda: True), Above(unsolvable, 5.0))
    assert not answer.accepted
    assert said[-1] == "    failed: the equations cannot be solved"


@pytest.mark.long
def test_a_recording_is_explained_with_another_threshold(tmp_path):
    make_case(tmp_path / "r", "hinge", [("gyro_bias", "imu1")], 3, "strong", seconds=6.0, rate=50.0)
    command = [sys.executable, "-m", "benchmarks.why", str(tmp_path / "r")]
    usual, never = (
        subprocess.run([*command, *more], capture_output=True, text=True, check=True).stdout
        for more in ((), ("--set", "ADMISSION.most_effects=0"))
    )
    assert "  gyro_bias at imu1, 0.96 sure\n" in usual
    assert "  taken: gyro_bias@imu1 (by the rule add)\n" in usual
    assert "  add (1): add the effects" in usual
    assert "gyro_bias@imu1" not in never

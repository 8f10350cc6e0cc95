"""Each recording of the table of regressions is diagnosed, and what must be said of it is said."""

from collections import Counter

import pytest

from imubench.diagnosis.config.shared import CONFIDENCE
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval
from imubench.format1 import read
from tests.regressions.said import Doubted, Exactly, First, NothingBut, Said, SomethingUnnamed, Sure
from tests.regressions.table import REGRESSIONS


def row(regression):
    """The regression as a parameter, expected to fail where it is open again."""
    marks = [pytest.mark.xfail(reason=regression.open, strict=True)] if regression.open else []
    return pytest.param(regression, id=regression.name, marks=marks)


@pytest.mark.slow
@pytest.mark.parametrize("regression", [row(r) for r in REGRESSIONS])
def test_regression(regression, tmp_path):
    regression.making.write(tmp_path / "r")
    diagnosis, _ = diagnose(read(tmp_path / "r")[0])
    for said in regression.said:
        said.check(diagnosis)


def test_every_row_has_a_name_of_its_own_and_says_something():
    assert [name for name, n in Counter(r.name for r in REGRESSIONS).items() if n > 1] == []
    assert all(r.said for r in REGRESSIONS)


def of(*findings: Finding) -> Diagnosis:
    """A diagnosis with these findings and the verdict that goes with them."""
    sure = {f.named for f in findings if f.confidence >= CONFIDENCE.counts}
    verdict = ("no mismatch", "explained", "unexplained", "partly explained")[(True in sure) + 2 * (False in sure)]
    return Diagnosis("r", "hinge", verdict, (2.0, 1.0), (), findings, (), FitQuality((2.0, 1.0)), "", 1.0)


def finding(effect: str, confidence: float = 0.95) -> Finding:
    return Finding(effect, "imu1", confidence, {}, Interval(10.0, (5.0, 15.0)))


@pytest.mark.parametrize(
    ("said", "right", "wrong"),
    [
        (Exactly("gyro_bias imu1"), of(finding("gyro_bias"), finding("gyro_scale", 0.4)), of(finding("gyro_scale"))),
        (Exactly(), of(finding("gyro_scale", 0.4)), of(finding("gyro_scale"))),
        (First("gyro_bias imu1"), of(finding("gyro_bias", 0.3), finding("gyro_scale")), of(finding("gyro_scale"))),
        (Doubted(), of(finding("gyro_bias", 0.6), finding("unknown")), of(finding("gyro_bias"))),
        (Doubted("gyro_bias"), of(finding("gyro_scale")), of(finding("gyro_bias"))),
        (Sure("gyro_bias"), of(finding("gyro_bias")), of(finding("gyro_bias", 0.9))),
        (SomethingUnnamed(), of(finding("unknown")), of(finding("gyro_bias"))),
        (NothingBut("gyro_bias"), of(), of(finding("gyro_scale", 0.1))),
    ],
)
def test_what_must_be_said_can_be_missed(said: Said, right, wrong):
    said.check(right)
    with pytest.raises(AssertionError):
        said.check(wrong)

"""What has no name and is a part of what the samples told is not said a second time."""

import pytest

from imubench.diagnosis.result import UNKNOWN, Finding, Interval, Where
from imubench.diagnosis.verdict.explanation import not_told

KNOCKS, ROUNDING = (Finding(name, "imu2", 0.95, {}, Interval(0.0, (0.0, 0.0))) for name in ("impacts", "quantisation"))


def unnamed(at, nat):
    where = Where(at, {"acc_x": 0.9}, (), (), "nothing clear", 0.9)
    return Finding(UNKNOWN, at, 0.9, {}, Interval(nat, (nat, nat)), where=where)


@pytest.mark.parametrize(
    ("told", "at", "nat", "said"),
    [
        (KNOCKS, "imu2", 0.0, False),  # a noise louder than declared, where knocks are
        (KNOCKS, "imu1", 0.0, True),
        (KNOCKS, "imu2", 80.0, True),  # a term that predicts is no knock
        (ROUNDING, "imu2", 80.0, False),
        (ROUNDING, "imu1", 80.0, True),
    ],
)
def test_what_is_said(told, at, nat, said):
    found = unnamed(at, nat)
    assert not_told([found], [told]) == ((found,) if said else ())


def test_a_louder_noise_with_its_name_stays_beside_knocks():
    noise = Finding("gyro_noise", "imu2", 0.9, {}, Interval(0.0, (0.0, 0.0)))
    assert not_told([noise], [KNOCKS]) == (noise,)

"""A finding's numbers: each by itself, a vector as a whole, and their digits."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.report.numbers import NOT_SHOWN, brief, rows, size
from imubench.diagnosis.result import Directions, Parameter


def test_a_vector_is_told_as_a_whole_and_what_is_not_seen_is_no_number():
    covariance = np.diag([1e-6, 0.02, 1e-6])
    p = Parameter([0.003, 0.2, 0.004], np.sqrt(np.diag(covariance)), "m", Directions(covariance, np.eye(3)[:, [1]]))
    table = list(rows("translation", p))
    assert [r[1:3] for r in table][1] == ("", NOT_SHOWN)
    assert table[0][1:3] == ("3.0", "1.0 to 5.0")
    # |(3, 0, 4)| = 5 mm, its std 1 mm as every direction of these has it, and so 5 std from none
    assert size("translation", p) == (
        "The translation as a whole, in the directions that are seen, is 5.0 mm long (3.0 to 7.0, 95 %), "
        "5.0 standard deviations from none."
    )
    none = replace(p, fixed=None)
    assert size("translation", none) == "" and all(r[1] for r in rows("translation", none))
    nothing = replace(p, fixed=Directions(covariance, np.eye(3)))
    assert size("translation", nothing) == ""


def test_marginals_that_all_hold_zero_may_be_far_from_it_together():
    u = np.array([1.0, -1.0]) / np.sqrt(2)
    covariance = 0.04 * np.eye(2) - 0.039 * np.outer(u, u)  # known well along u alone
    p = Parameter([0.1, -0.1], np.sqrt(np.diag(covariance)), "m/s^2", Directions(covariance, np.zeros((2, 0))))
    assert all(r[2].startswith("−") or " to −" not in r[2] for r in rows("bias", p))
    away = 0.1 * np.sqrt(2) / np.sqrt(0.001)
    assert f"{away:.1f} standard deviations from none" in size("bias", p)


@pytest.mark.parametrize(("value", "text"), [(69.4335, "69.4"), (0.1702, "0.17"), (0.00249, "0.0025"), (0.0, "0"),
                                             (1234.5, "1234"), (1.0, "1.00")])  # fmt: skip
def test_sizes_have_the_digits_that_a_reader_needs(value, text):
    assert brief(value) == text

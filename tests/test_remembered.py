"""Fits that are asked for more than once in a diagnosis."""

from dataclasses import dataclass

import numpy as np

from imubench.diagnosis.remembered import remembered, remembering


@dataclass(frozen=True, eq=False)
class Solved:
    knots: int


def counting():
    """A function that solves, and the list of what it was really asked."""
    asked = []

    @remembered
    def solve(values, noise, steps=6):
        asked.append((values, noise, steps))
        return Solved(100)

    return solve, asked


def test_the_same_question_has_the_same_answer():
    solve, asked = counting()
    with remembering():
        one = solve(np.arange(3.0), {"gyro": 1.0})
        assert solve(np.arange(3.0), noise={"gyro": 1.0}, steps=6) is one
    assert len(asked) == 1


def test_another_number_shape_level_or_function_is_another_question():
    solve, asked = counting()
    other, asked_of_other = counting()
    with remembering():
        for values in (np.arange(3.0), np.arange(3.0)[None], np.array([0.0, 1.0, 2.0 + 1e-15])):
            solve(values, {"gyro": 1.0})
        solve(np.arange(3.0), {"gyro": 2.0})
        solve(np.arange(3.0), {"accel": 1.0})
        solve(np.arange(3.0), {"gyro": 1.0}, steps=3)
        other(np.arange(3.0), {"gyro": 1.0})
    assert len(asked) == 6
    assert len(asked_of_other) == 1


def test_nothing_is_kept_beyond_the_block_or_outside_of_one():
    solve, asked = counting()
    for _ in range(2):
        with remembering():
            solve(np.arange(3.0), {})
        solve(np.arange(3.0), {})
    assert len(asked) == 4


def test_only_so_many_knots_are_kept_the_last_asked_for_first():
    solve, asked = counting()
    with remembering(most=250):  # two of 100 knots
        for steps in (1, 2, 1, 3, 1, 2):
            solve(np.zeros(1), {}, steps)
    assert [steps for *_, steps in asked] == [1, 2, 3, 2]

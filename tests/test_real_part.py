"""A minute's part of the suite of real recordings, from files to scores: `.ci/run` has it, `make test` has not.

What a diagnosis says in so little time is not asked here, only that nothing which it says is wrong: `make real` judges.
"""

import resource

import numpy as np
import pytest

from benchmarks.real.__main__ import line, run
from benchmarks.real.cases import cases, chosen
from benchmarks.real.sources import sources
from imubench.terminal import Terminal

LIMITS = {"diodem/trial1/3-4-rigid/20-40": 10.0, "broad/24_*/40-80": 15.0}  # s of processor time


@pytest.mark.long
@pytest.mark.parametrize("pattern", LIMITS)
def test_a_part_of_the_suite(pattern, recordings, tmp_path):
    some = chosen(cases(list(sources(recordings))), [pattern])
    (answer,) = run(some, tmp_path, LIMITS[pattern], 1, Terminal(stderr=True))
    one = line(answer)
    assert one.score is not None, one.failed
    assert not one.score.wrong
    if one.score.axes:
        assert np.degrees(one.score.axes["seel2012"][0].off).max() < 1.4  # of screwed-on IMUs, as qmt's
    spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    (again,) = run(some, tmp_path, LIMITS[pattern], 1, Terminal(stderr=True))
    assert again == answer
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime == spent  # nothing is done twice

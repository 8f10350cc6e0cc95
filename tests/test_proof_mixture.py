"""The mixture of cases: its shares, its seeds, and that every case of it can be read."""

import collections
import json

import numpy as np
import pytest

from imubench import format1
from imubench.proof.mixture import RIVALS, listed, make, mixture


def test_the_shares_are_those_that_are_said():
    questions = mixture(1, 200)
    kinds = collections.Counter(q.kind for q in questions)
    assert kinds == {"none": 50, "one": 80, "several": 40, "outside": 30}
    assert 4 <= sum(not q.observable for q in questions) <= 8
    assert {len(q.effects) for q in questions if q.kind == "several"} == {2, 3}
    assert {q.rig for q in questions} == {"hinge", "pendulum", "free"}
    for q in questions:
        names = [name for name, _ in q.effects]
        assert len(names) == len(set(names))
        assert not any(len(rivals & set(names)) > 1 for rivals in RIVALS)
        assert q.options["declare_noise"] or not {"gyro_noise", "accel_noise"} & set(names)


def test_a_seed_is_a_mixture_and_another_is_another():
    first, again, other = mixture(1, 40), mixture(1, 40), mixture(2, 40)
    assert first == again and first != other
    assert len({q.seed for q in first}) == 40
    json.dumps([listed(q) for q in first])


@pytest.mark.slow
def test_every_case_is_written_and_read(tmp_path):
    short, aims = {"seconds": 6.0}, []
    for i, question in enumerate(mixture(3, 32)):
        if question.options["seconds"] > 6:
            question.options.update(short)
        truth = make(question, tmp_path / str(i))
        recording, _ = format1.read(tmp_path / str(i))
        assert recording.name == "recording" and recording.rig == question.rig
        assert [(e["effect"], e["at"]) for e in truth["effects"]] == question.effects
        assert truth["kind"] == question.kind
        if not question.observable:
            assert all(has < 3 for has in truth["visibility"])
        for want, has in zip(question.wanted, truth["visibility"], strict=True):
            aims += [(want, has)] if want else []
        assert all(np.isfinite(imu.accel).all() for imu in recording.imus)
        json.dumps(truth)
    met = [abs(has / want - 1) < 0.06 for want, has in aims if has is not None]
    assert len(met) > 4 and np.mean(met) > 0.8  # the rest: limits that hide a fault, turns that hardly show

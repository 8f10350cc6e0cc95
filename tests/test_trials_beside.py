"""Baselines on the cases of a proof, and the library without an effect."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from imubench import format1
from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Where
from imubench.proof.case import build, make_case
from imubench.trials import blind
from imubench.trials.baselines import NO_GAIN, l1, lasso, residual_size
from imubench.trials.beside import to_leave_out, without
from imubench.trials.make import answers
from imubench.trials.oracle import oracle
from imubench.trials.scoring import score

ASKS = """
import pathlib, sys
from imubench import effects, format1
recording, _ = format1.read(pathlib.Path(sys.argv[1]))
names = {e.name for e, _ in effects.possible(recording)} | set(effects.EFFECTS)
print(sys.argv[2])
pathlib.Path(sys.argv[2]).mkdir()
pathlib.Path(sys.argv[2], "diagnosis.json").write_text("[%s]" % ",".join('"%s"' % n for n in sorted(names)))
"""
BIAS = ("accel_bias", "imu2", {"bias": np.array([0.4, -0.5, 0.3])})


def biased(folder: Path, seed: int = 3):
    """A short hinge with a large bias, and its truth as the trials have it."""
    options = {"seconds": 10.0, "rate": 50.0, "gyro_noise": 0.002}
    truth = make_case(folder, "hinge", [BIAS], seed, **options)
    case = build("hinge", [BIAS], seed, **options)
    told = {"kind": "one", "observable": True, "visibility": [100.0], "freedom": [3], "bounds": [None]}
    return truth | told | {"answers": [answers(e, case.options) for e in case.effects]}


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """A biased recording as a diagnosis begins with it, and its truth."""
    folder = tmp_path_factory.mktemp("biased") / "recording"
    truth = biased(folder)
    return begin(format1.read(folder)[0]), truth


def test_lasso_meets_its_conditions_of_optimality():
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((40, 8))
    columns /= np.linalg.norm(columns, axis=0)
    matrix, force, penalty = columns.T @ columns, 3 * columns.T @ (columns[:, 2] + 0.8 * columns[:, 5]), 1.0
    z = lasso(matrix, force, penalty)
    gradient = force - matrix @ z
    there = z != 0
    assert {2, 5} <= set(np.flatnonzero(there))
    assert gradient[there] == pytest.approx(penalty * np.sign(z[there]), abs=1e-5)  # where the descent stops
    assert (np.abs(gradient[~there]) <= penalty + 1e-5).all()


@pytest.mark.long
def test_l1_and_the_oracle_find_a_large_bias(told):
    start, truth = told
    assert ("accel_bias", "imu2") in [(f.effect, f.at) for f in l1(start.first).findings]
    said = oracle(start, truth)
    assert [(f.effect, f.at) for f in said.findings] == [("accel_bias", "imu2")]
    s = score("000", truth, said, 0.0, np.inf)
    assert s.first_right and len(s.errors) == 1 and len(s.errors[0].over_std) == 3
    assert oracle(start, truth | {"effects": []}).findings == ()


@pytest.mark.long
def test_the_oracle_reads_off_the_samples_what_they_show_and_nothing_that_it_was_not_told(told):
    start, truth = told
    step = Finding("quantisation", "imu1", 0.99, {}, NO_GAIN)
    lost = Finding("dropouts", "imu2", 0.99, {}, NO_GAIN)
    start = replace(start, samples=replace(start.samples, findings=(step, lost)))
    both = truth | {"effects": [*truth["effects"], {"effect": "dropouts", "at": "imu2", "inside": True}]}
    assert {(f.effect, f.at) for f in oracle(start, both).findings} == {("accel_bias", "imu2"), ("dropouts", "imu2")}


@pytest.mark.parametrize(("misfit", "expected"), [(1.2, ()), (4.0, (("unknown", "imu2"),))])
def test_the_size_of_the_residual_has_a_place_and_no_name(misfit, expected):
    where = (Where("imu2", {"acc_x": 1.0}, (), (), "", 1.0),)
    ours = Diagnosis("r", "hinge", "no mismatch", (misfit, misfit), where, (), (), FitQuality((1.0, 1.0)), "", 1.0)
    assert tuple((f.effect, f.at) for f in residual_size(ours, 1.59).findings) == expected


@pytest.mark.long
def test_an_effect_left_out_is_not_in_the_library_of_the_diagnosis(tmp_path):
    biased(tmp_path / "recording")
    (tmp_path / "asks.py").write_text(ASKS)
    command = f"{tmp_path / 'asks.py'} {{recording}} {{out}}"
    libraries = []
    for left_out in ("-", "accel_bias"):
        kept = tmp_path / left_out
        run = blind.diagnosed(tmp_path / "recording", kept, command, 60.0, blind.Children(), left_out)
        assert (run.code, run.refused) == (0, ()), run
        libraries.append(set(json.loads((kept / "diagnosis.json").read_text())))
    assert libraries[0] - libraries[1] == {"accel_bias"}


@pytest.mark.long
def test_only_what_was_found_and_has_no_twin_is_left_out(told):
    start, truth = told
    said = oracle(start, truth)
    found = score("000", truth, said, 0.0, np.inf)
    assert to_leave_out({"000": truth}, [found]) == {"000": "accel_bias"}
    twin = truth | {"answers": [[*truth["answers"][0], {"effect": "gravity", "at": "world", "parameters": {}}]]}
    assert to_leave_out({"000": twin}, [found]) == {}
    again = score("000", without(truth), said, 0.0, np.inf)
    assert (again.kind, again.flagged, again.located, again.wrong) == ("outside", False, False, ("accel_bias at imu2",))

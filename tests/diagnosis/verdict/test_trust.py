"""Doubts about a model that was found: raised where the halves of a recording tell different numbers, else not.

The recordings come from the generator in `proof/`, which shares no code with the diagnosis.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from imubench.correction.corrected import corrected
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.fit_summary import weighed
from imubench.diagnosis.result import Diagnosis, Doubt
from imubench.diagnosis.result_file import FILE_NAME, as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.verdict.estimate_shift import spread_of
from imubench.diagnosis.verdict.trust import (
    PREDICTION,
    Question,
    allowed,
    doubts,
    halves_that_differ,
    implausible,
    matters,
)
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.format1 import read
from imubench.proof.case import make_case
from tests.test_estimate_with import finding, saying


@pytest.fixture(scope="module")
def fits(tmp_path_factory):
    """A hinge's fit as declared and with one effect named, of a recording with an effect in it."""

    def made(effect, at, named, seed=3, **options):
        folder = tmp_path_factory.mktemp("trust") / "r"
        effects = [(effect, at, options.pop("parameters"))] if "parameters" in options else [(effect, at)]
        make_case(folder, "hinge", effects, seed, "strong", **({"seconds": 12.0, "rate": 50.0} | options))
        first = nominal_fit(read(folder)[0])
        return first, with_noise(refit(first, (Hypothesis(EFFECTS[named], at),)), 2)

    return made


def both(first, fit):
    return (weighed(one, declared(first.model)) for one in (first, fit))


def test_nothing_speaks_against_the_effect_that_is_there(fits):
    first, fit = fits("gyro_scale", "imu2", "gyro_scale")
    before, after = both(first, fit)
    assert doubts(fit, before, after) == ()
    assert after.left_out <= allowed(after)


def spliced(tmp_path, first, second):
    """The fit of a hinge whose second gyroscope has a scale in the first half, and another one in the second."""

    def made(scale):
        folder = tmp_path / f"{scale[0]:g}-{scale[1]:g}"
        make_case(folder, "hinge", [("gyro_scale", "imu2", {"scale": scale})], 3, seconds=12.0, rate=50.0)
        return read(folder)[0]

    one, two = made(first), made(second)  # the same motion and noise
    late = one.imus[1].time > one.imus[1].time.mean()
    gyro = np.where(late[:, None], two.imus[1].gyro, one.imus[1].gyro)
    both_halves = replace(one, imus=(one.imus[0], replace(one.imus[1], gyro=gyro)))
    fit = refit(nominal_fit(both_halves), (Hypothesis(EFFECTS["gyro_scale"], "imu2"),))
    return with_noise(fit, 2)


def test_a_scale_that_is_another_in_either_half_is_doubted(tmp_path):
    said = halves_that_differ(spliced(tmp_path, [0.02] * 3, [0.05] * 3))
    assert [doubt.of for doubt in said] == ["gyro_scale@imu2.scale"]
    assert "the halves of the recording differ by 0.03" in said[0].why


def test_a_small_part_of_a_vector_that_is_another_in_either_half_is_not_doubted(tmp_path):
    """A tenth of the whole: what is taken out with it is right but for a hundredth of its power."""
    assert halves_that_differ(spliced(tmp_path, [0.1, 0.004, 0.1], [0.1, 0.018, 0.1])) == ()


@pytest.mark.long
def test_a_number_far_from_what_is_plausible_is_doubted_and_springs_without_damping_are_not(fits):
    _, fit = fits("rocking_mount", "imu2", "rocking_mount")

    def off(name, by):
        key = f"rocking_mount@imu2.{name}"
        prior = fit.model.priors[key]
        values = fit.state.values | {
            key: np.broadcast_to(prior.start + by * prior.std, np.shape(fit.state.values[key]))
        }
        return {d.of for d in implausible(replace(fit, state=replace(fit.state, values=values)))}

    assert "rocking_mount@imu2.com" in off("com", 6.0)
    assert "rocking_mount@imu2.com" in off("com", -6.0)
    assert "rocking_mount@imu2.damping_ratio" in off("damping_ratio", 6.0)
    assert "rocking_mount@imu2.damping_ratio" not in off("damping_ratio", -6.0)


@pytest.mark.long
def test_a_number_is_doubted_only_where_it_moves_what_a_user_asks_for(tmp_path):
    """A scale that is 0.015 off, half of what the halves differ by, makes the angle worse by 0.09 deg, chance aside."""
    fit = spliced(tmp_path, [0.02] * 3, [0.05] * 3)
    (question,) = halves_that_differ(fit)
    spread = spread_of(fit)
    assert matters(fit, question, (0.05, 1.0), spread)
    assert not matters(fit, question, (60.0, 1000.0), spread)
    same = Question(question.of, "", fit.state.values[question.of])
    assert not matters(fit, same, (0.01, 0.1), {})  # what the solver has left to do, at most
    known = weighed(fit, declared(fit.model))
    asked = [doubts(fit, known, known, (0.05, 1.0), left) for left in ((), {"gyro_scale@imu2"})]
    assert [[d.of for d in some] for some in asked] == [["gyro_scale@imu2.scale"], []]


@pytest.mark.long
def test_a_model_that_predicts_worse_than_the_declared_one_is_doubted(fits):
    first, fit = fits("gyro_scale", "imu2", "gyro_scale")
    before, after = both(first, fit)
    assert PREDICTION in {d.of for d in doubts(fit, after, before)}


def doubted(recording) -> Diagnosis:
    told = saying(recording, finding("gyro_bias", "imu1", bias=[0.1, 0.0, 0.0]))
    return replace(told, verdict="partly explained", doubts=(Doubt("imu1.rotation", "the halves differ"),))


def test_a_doubted_model_explains_nothing_and_corrects_nothing(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 1, "weak", seconds=2.0, rate=50.0, name="case")
    recording = read(tmp_path / "r")[0]
    told = doubted(recording)
    with pytest.raises(InputError, match=r"doubts about imu1\.rotation"):
        replace(told, verdict="explained")
    with pytest.raises(
        InputError, match=r"expected a model that can be trusted, got one that is doubted: imu1\.rotation"
    ):
        corrected(recording, told)


def test_doubts_stand_in_the_file_and_come_back(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 1, "weak", seconds=2.0, rate=50.0, name="case")
    told = doubted(read(tmp_path / "r")[0])
    (tmp_path / FILE_NAME).write_text(json.dumps(as_dict(told)))
    assert read_diagnosis(tmp_path).doubts == told.doubts
    assert "doubts" not in as_dict(replace(told, verdict="explained", doubts=()))

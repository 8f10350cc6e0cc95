"""What a finding tells: numbers read off fitted ones carry their errors."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Gain, Kept
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.selected import Selection
from imubench.diagnosis.solve.refit import refit
from imubench.diagnosis.verdict.effect_parameters import propagated_std
from imubench.diagnosis.verdict.findings import findings, overshadowed
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

BIAS, SCALE = Hypothesis(EFFECTS["gyro_bias"], "imu1"), Hypothesis(EFFECTS["accel_scale"], "imu1")


def kept(h, nat):
    return Kept(h, nat, Gain(nat, 0.9 * nat, 1.1 * nat, np.full(3, nat / 3)), ())


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("findings") / "case"
    make_case(folder, rig="free", effects=[("gyro_bias", "imu1"), ("accel_scale", "imu1")], seed=12, seconds=6.0)
    return refit(nominal_fit(read(folder)[0]), (BIAS, SCALE))


def at(fit, times):
    """The fit with every noise at so many times its declared level."""
    return replace(fit, noise=fit.noise | {n: times * std for n, std in declared(fit.model).items()})


@pytest.mark.long
def test_a_weak_name_is_doubted_beside_a_strong_one_in_a_model_that_leaves_more(fit):
    """At 1.2 times the noise what is left is (1.44 - 1) / 2 nat per number."""
    left = 0.22 * sum(r.residual.value.size for r in fit.measured)
    strong, weak = kept(BIAS, 0.5 * left), kept(SCALE, 0.05 * left)
    doubted = Selection(at(fit, 1.2), (weak, strong), ())
    assert overshadowed(doubted) == [SCALE]
    assert {f.effect: f.confidence for f in findings(doubted)} == {"gyro_bias": 0.96, "accel_scale": 0.6}


@pytest.mark.parametrize(("times", "share"), [(1.2, 0.2), (0.95, 0.05)])
def test_a_name_worth_more_of_what_is_left_is_not(fit, times, share):
    left = 0.22 * sum(r.residual.value.size for r in fit.measured)
    two = Selection(at(fit, times), (kept(BIAS, 3 * left), kept(SCALE, share * left)), ())
    assert overshadowed(two) == []


def test_nor_is_one_that_stands_alone(fit):
    assert overshadowed(Selection(at(fit, 1.2), (kept(BIAS, 10.0),), ())) == []


def test_a_hum_s_amplitude_has_the_error_of_its_cosine_and_sine():
    h = Hypothesis(EFFECTS["vibration"], "imu1")
    rng = np.random.default_rng(3)
    amplitude, phase = np.array([0.4, -0.2, 0.0]), 0.9
    values = {"frequency": np.array([17.3]), "cosine": amplitude * np.sin(phase), "sine": amplitude * np.cos(phase)}
    std = {h.key("frequency"): np.array([0.01])}
    std |= {h.key(name): np.array([0.004, 0.006, 0.003]) for name in ("cosine", "sine")}
    found = propagated_std(h, values, std, 0.01)["amplitude"]
    drawn = []
    for _ in range(4000):
        moved = {name: x + std[h.key(name)] * rng.standard_normal(x.size) for name, x in values.items()}
        x = h.effect.read(moved, {}, 0.01)["amplitude"]
        drawn.append(x * np.sign(x[0]))
    np.testing.assert_allclose(found, np.std(drawn, axis=0), rtol=0.05)  # 1.1 % for 4000 draws, and what is not linear


@pytest.mark.long
def test_names_at_a_sensor_with_numbers_that_none_has_are_doubted(fit):
    """73 % of one axis: what is there has another law, and everything at the sensor makes up for it."""
    two = (kept(BIAS, 500.0), kept(SCALE, 300.0))
    assert {f.confidence for f in findings(Selection(at(fit, 1.0), two, ()))} == {0.96}
    values = fit.state.values | {SCALE.key("scale"): np.array([0.02, -0.73, 0.01])}
    odd = replace(at(fit, 1.0), state=replace(fit.state, values=values))
    assert {f.confidence for f in findings(Selection(odd, two, ()))} == {0.2}

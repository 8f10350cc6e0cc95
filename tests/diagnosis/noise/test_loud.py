"""Noise beyond what is declared: white by its name, anything else as unknown, where it is."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.config.shared import DECLARED_NOISE
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.noise_levels import levels
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.pooled import with_pooled_noise
from imubench.diagnosis.noise.reml import with_settled_noise
from imubench.diagnosis.residual_checks.excess_noise import excess_noise, left_over, off_its_equation
from imubench.diagnosis.result import UNKNOWN, Where
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.format1 import read
from imubench.proof.case import make_case

WHERE = Where("imu2", {"gyr_x": 0.9}, (), (), "nothing clear", 0.9)


@pytest.fixture(scope="module")
def clean(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clean")
    make_case(folder / "r", "hinge", [], 21, seconds=15.0)
    return read(folder / "r")[0]


def noisier(recording, added):
    """The nominal fit of a recording whose imu2 has `added` (n, 3) on its gyroscope, not declared."""
    imus = [replace(i, gyro=i.gyro + added(i)) if i.name == "imu2" else i for i in recording.imus]
    return nominal_fit(replace(recording, imus=tuple(imus)))


def at_levels(fit, noise):
    return solve(fit.model, fit.state, noise, fit.anchor)


@pytest.mark.long
def test_a_triple_of_which_no_sample_counts_is_not_asked(clean):
    """As of an accelerometer that clips throughout; its level is still the one that was declared."""
    fit = nominal_fit(clean, {"imu2.accel": np.zeros(clean.imus[1].time.size, dtype=bool)})
    told = declared(fit.model)
    fit = replace(fit, noise=fit.noise | {"imu2.accel": told["imu2.accel"]})
    assert excess_noise(fit, [WHERE], set()) == []


@pytest.mark.long
def test_what_is_declared_is_not_loud(clean):
    assert excess_noise(nominal_fit(clean), [WHERE], set()) == []


@pytest.mark.long
def test_what_is_left_over_is_what_costs_more_than_noise_may(clean):
    assert left_over(nominal_fit(clean)) == 0.0
    fit = noisier(clean, lambda i: 0.02 * np.sin(2 * np.pi * 31.0 * i.time)[:, None] * np.ones(3))
    told = declared(fit.model)["imu2.gyro"]
    power = (fit.noise["imu2.gyro"] / told) ** 2
    assert power > 2 * DECLARED_NOISE.most_power
    assert left_over(fit) == pytest.approx(
        0.5 * clean.imus[1].gyro.size * (power / DECLARED_NOISE.most_power - 1), rel=0.1
    )


@pytest.mark.long
@pytest.mark.parametrize("shared", [False, True])
def test_louder_white_noise_has_its_name_and_size(clean, shared):
    """Also where both IMUs share what the one is blamed for: each is judged by what is left of its own."""
    rng = np.random.default_rng(5)
    fit = noisier(clean, lambda i: 0.004 * rng.standard_normal(i.gyro.shape))
    if shared:
        fit = with_pooled_noise(fit)
        assert fit.noise["imu1.gyro"] > 1.3 * declared(fit.model)["imu1.gyro"]
    (told,) = excess_noise(fit, [WHERE], set())
    assert (told.effect, told.at) == ("gyro_noise", "imu2")
    size, own = told.parameters["std"], clean.imus[1].gyro_noise_std
    assert size.value == pytest.approx(np.hypot(0.004, own), abs=4 * size.std + 0.1 * own)  # `own` is a declaration
    assert excess_noise(fit, [WHERE], {"imu2"}) == []


@pytest.mark.long
def test_a_level_far_from_what_is_left_is_estimated_again(clean):
    fit = nominal_fit(clean)
    assert with_settled_noise(fit) is fit
    off = at_levels(fit, fit.noise | {"imu2.accel": 4 * fit.noise["imu2.accel"]})
    again = with_settled_noise(off)
    assert again.noise["imu2.accel"] == pytest.approx(levels(again)[0]["imu2.accel"], rel=0.05)
    assert again.noise["imu2.accel"] < 1.2 * fit.noise["imu2.accel"]  # of two on one motion the doubted stays louder


@pytest.mark.slow
def test_noise_that_comes_with_the_motion_has_no_name(clean):
    rng = np.random.default_rng(6)
    fit = noisier(clean, lambda i: 0.004 * np.abs(i.gyro) * rng.standard_normal(i.gyro.shape))
    (told,) = excess_noise(fit, [WHERE], set())
    assert (told.effect, told.at, told.where) == (UNKNOWN, "imu2", WHERE)


@pytest.mark.long
def test_noise_that_is_loud_now_and_then_has_no_name(clean):
    """White, and as loud in quick moments as in calm ones: its tail tells it from a louder noise."""
    rng = np.random.default_rng(8)

    def rare(i):
        return 0.015 * rng.standard_normal(i.gyro.shape) * (rng.random((i.time.size, 1)) < 0.05)

    (told,) = excess_noise(noisier(clean, rare), [WHERE], set())
    assert (told.effect, told.at, told.where) == (UNKNOWN, "imu2", WHERE)


@pytest.mark.slow
def test_coloured_noise_has_no_name(clean):
    rng = np.random.default_rng(7)

    def slow(i):
        walk = np.zeros(i.gyro.shape)
        for k in range(1, len(walk)):
            walk[k] = 0.7 * walk[k - 1] + 0.004 * rng.standard_normal(3)
        return walk

    (told,) = excess_noise(noisier(clean, slow), [WHERE], set())
    assert (told.effect, told.at) == (UNKNOWN, "imu2")


@pytest.mark.long
def test_a_level_of_which_the_fit_leaves_next_to_nothing_is_not_told(tmp_path):
    """A free body with a pose: its accelerometer alone says how it is pushed, and the motion follows 98 % of it."""
    options = {"rate": 128.0, "rate2": 128.0, "band": 8.7, "vigour": 0.53, "rest": 0.03, "pose": True}
    options |= {"gyro_noise": 0.0034, "accel_noise": 0.0104, "colour": 0.18, "seconds": 15.0}
    make_case(tmp_path / "r", "free", [], 20261121 + 149, **options)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert (fit.noise["imu1.accel"] / declared(fit.model)["imu1.accel"]) ** 2 > DECLARED_NOISE.most_power
    assert float(np.mean(1 - levels(fit)[1]["imu1.accel"])) < 0.05
    assert excess_noise(fit, [replace(WHERE, at="imu1")], set()) == []


@pytest.mark.parametrize(
    ("rig", "asked", "found"), [("pendulum", "wind", True), ("pendulum", None, False), ("hinge", None, False)]
)
def test_a_swing_that_does_not_go_as_its_equation_says_has_a_torque_without_a_name(rig, asked, found, tmp_path):
    make_case(tmp_path / "r", rig, [(asked, "joint")] if asked else [], 31, seconds=10.0, swing=True, base="fixed")
    said = off_its_equation(nominal_fit(read(tmp_path / "r")[0]))
    assert [(f.effect, f.at) for f in said] == ([(UNKNOWN, "joint")] if found else [])
    if found:
        assert sum(said[0].where.channels.values()) == pytest.approx(1.0, abs=0.2)

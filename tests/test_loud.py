"""Noise beyond what is declared: white by its name, anything else as unknown, where it is."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.diagnose import nominal_fit
from imubench.diagnosis.loud import loud
from imubench.diagnosis.result import UNKNOWN, Where
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


def test_what_is_declared_is_not_loud(clean):
    assert loud(nominal_fit(clean), [WHERE], set()) == []


def test_louder_white_noise_has_its_name_and_size(clean):
    rng = np.random.default_rng(5)
    fit = noisier(clean, lambda i: 0.004 * rng.standard_normal(i.gyro.shape))
    (told,) = loud(fit, [WHERE], set())
    assert (told.effect, told.at) == ("gyro_noise", "imu2")
    size, own = told.parameters["std"], clean.imus[1].gyro_noise_std
    assert size.value == pytest.approx(np.hypot(0.004, own), abs=4 * size.std + 0.1 * own)  # `own` is a declaration
    assert loud(fit, [WHERE], {"imu2"}) == []


def test_noise_that_comes_with_the_motion_has_no_name(clean):
    rng = np.random.default_rng(6)
    fit = noisier(clean, lambda i: 0.004 * np.abs(i.gyro) * rng.standard_normal(i.gyro.shape))
    (told,) = loud(fit, [WHERE], set())
    assert (told.effect, told.at, told.where) == (UNKNOWN, "imu2", WHERE)


def test_coloured_noise_has_no_name(clean):
    rng = np.random.default_rng(7)

    def slow(i):
        walk = np.zeros(i.gyro.shape)
        for k in range(1, len(walk)):
            walk[k] = 0.7 * walk[k - 1] + 0.004 * rng.standard_normal(3)
        return walk

    (told,) = loud(noisier(clean, slow), [WHERE], set())
    assert (told.effect, told.at) == (UNKNOWN, "imu2")

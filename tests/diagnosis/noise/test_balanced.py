"""What a fit cannot explain is shared by two IMUs of one motion before it is asked which of them it is at."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.pooled import with_pooled_noise
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.fixture(scope="module")
def fit(tmp_path_factory):
    folder = tmp_path_factory.mktemp("balanced") / "case"
    make_case(folder, "hinge", seed=31, seconds=8.0)
    return nominal_fit(read(folder)[0])


@pytest.mark.parametrize("doubted", [1.45, 7.0])  # 1.44 is called loud
def test_the_power_that_one_imu_is_blamed_for_is_shared(fit, doubted):
    told = declared(fit.model)
    blamed = {"imu1.accel": 0.85 * told["imu1.accel"], "imu2.accel": doubted * told["imu2.accel"]}
    found = with_pooled_noise(replace(fit, noise=fit.noise | blamed))
    times = [found.noise[name] / told[name] for name in blamed]
    assert times == pytest.approx([np.sqrt((0.85**2 + doubted**2) / 2)] * 2)
    assert {n: std for n, std in found.noise.items() if n not in blamed} == {
        n: std for n, std in fit.noise.items() if n not in blamed
    }


@pytest.mark.parametrize("times", [(0.95, 1.1), (1.4, 7.0)])
def test_levels_near_the_declared_or_both_louder_are_left(fit, times):
    told = declared(fit.model)
    asked = replace(
        fit, noise=fit.noise | {f"imu{i + 1}.accel": t * told[f"imu{i + 1}.accel"] for i, t in enumerate(times)}
    )
    assert with_pooled_noise(asked) is asked

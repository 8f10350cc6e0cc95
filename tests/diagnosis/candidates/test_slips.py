"""When a mount slipped: a slip at each of many moments is worth what its own columns say."""

import numpy as np
import pytest

from imubench.diagnosis.candidates.slips import BEFORE_THE_RECORDING, slip, slopes
from imubench.diagnosis.criteria.onset_scan import After
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.solve.schur import Base, promise
from imubench.effects import EFFECTS
from imubench.effects.mounts import SLIP, Slips
from imubench.format1 import read
from imubench.proof.case import make_case

TURN = {"rotation": [0.032, 0.008, -0.009], "translation": [-0.005, 0.002, 0.004], "time": 10.48}


@pytest.fixture(scope="module")
def watched(tmp_path_factory):
    """A free body whose pose is measured, and the IMU on it slips: only its own turn tells when."""
    folder = tmp_path_factory.mktemp("watched") / "r"
    make_case(folder, "free", [("mount_shift", "imu1", TURN)], 565739880, seconds=15.0, band=4.6)
    return nominal_fit(read(folder)[0])


@pytest.mark.parametrize("at", [3.0, 10.4, 14.7])
def test_a_slip_promises_what_its_own_columns_do(watched, at):
    base, prior = Base.of(watched), np.repeat([0.1, 0.02], 3)
    after = After.of(base, slopes(base, Hypothesis(Slips(BEFORE_THE_RECORDING), "imu1")))
    alone = slopes(base, Hypothesis(Slips(np.array([at])), "imu1"))
    times = {r.name: r.time for r in watched.measured}
    only = [(name, column * (times[name] >= at)[:, None, None]) for name, column in alone.items()]
    exact = promise(*base.reduced(only, 6), prior).evidence
    (promised,) = after.promises(np.array([at + SLIP]), prior, alone, SLIP)
    assert promised == pytest.approx(exact, rel=0.01, abs=0.1)  # the last knot of the slip, to either side


def test_a_slip_of_a_body_whose_pose_is_measured_is_dated(watched):
    assert slip(Base.of(watched), Hypothesis(EFFECTS["mount_shift"], "imu1")) == pytest.approx(
        TURN["time"] - watched.model.start, abs=0.1
    )


@pytest.mark.long
def test_a_slip_of_a_hinge_is_dated(tmp_path):
    truth = make_case(tmp_path / "r", "hinge", [("mount_shift", "imu2")], 100, seconds=15.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    true = float(truth["effects"][0]["parameters"]["time"])
    assert slip(Base.of(fit), Hypothesis(EFFECTS["mount_shift"], "imu2")) == pytest.approx(
        true - fit.model.start, abs=0.1
    )


@pytest.mark.long
def test_a_slip_that_does_not_turn_the_sensor_is_dated_by_its_peak(tmp_path):
    """From moments 2 s apart none led there, and a pivot that moves was found instead (11,175 nat)."""
    moved = {"rotation": [0.0, 0.0, 0.0], "translation": [-0.0019, 0.0028, 0.005], "time": 8.207}
    make_case(tmp_path / "r", "pendulum", [("mount_shift", "imu1", moved)], 46, seconds=15.0, band=2.12, vigour=1.37)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert slip(Base.of(fit), Hypothesis(EFFECTS["mount_shift"], "imu1")) == pytest.approx(
        moved["time"] - fit.model.start, abs=0.06
    )

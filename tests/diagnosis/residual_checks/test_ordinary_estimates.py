"""What ordinary estimates say: a filter at rest, an independent filter, and recordings without an effect."""

import numpy as np
import pytest

from imubench import rotations
from imubench.diagnosis.config.solve import START
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks.ordinary_estimates import OrdinaryEstimates, inclination
from imubench.diagnosis.samples.screening import check_samples
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case

SHORT = {"seconds": 8.0, "rate": 50.0, "band": 1.9, "vigour": 1.5}


def deg(one, other):
    return np.degrees(np.sqrt(np.mean(rotations.angle_between(one, other) ** 2)))


@pytest.mark.parametrize(("bias", "tilt"), [((0.01, 0.0, 0.0), 0.01 * START.levelling_s), ((0.0, 0.0, 0.01), 0.0)])
def test_at_rest_a_bias_across_gravity_tilts_by_the_time_constant(bias, tilt):
    """A low-pass lags by tau behind what turns steadily; about the vertical nothing is seen."""
    time = np.arange(0.0, 40.0, 0.01)
    up = inclination(time, np.tile(bias, (time.size, 1)), np.tile([0.0, 0.0, 9.81], (time.size, 1)))
    assert float(rotations.angle_between(up[-1], np.array([0.0, 0.0, 1.0]))) == pytest.approx(tilt, rel=0.01, abs=1e-6)


def test_it_is_vqf_without_its_bias(tmp_path):
    """From six time constants on the two, which begin otherwise, agree."""
    vqf = pytest.importorskip("vqf", reason="needs the extra: pip install 'imubench[filters]'")
    make_case(tmp_path / "r", "hinge", seed=5, **(SHORT | {"seconds": 30.0}))
    imu = read(tmp_path / "r")[0].imu("imu1")
    peer = vqf.VQF(float(np.median(np.diff(imu.time))), motionBiasEstEnabled=False, restBiasEstEnabled=False)
    q = peer.updateBatch(np.ascontiguousarray(imu.gyro), np.ascontiguousarray(imu.accel))["quat6D"]
    late = imu.time > imu.time[0] + 6 * START.levelling_s
    ours = inclination(imu.time, imu.gyro, imu.accel)
    assert deg(ours[late], rotations.rotate_back(q, [0.0, 0.0, 1.0])[late]) < 0.02


def test_a_bias_moves_what_the_same_recording_without_it_says(tmp_path):
    """By the filter on both recordings: within a tenth of its effect, for the bias is fitted."""
    bias = ("gyro_bias", "imu2", {"bias": [0.02, 0.01, -0.01]})
    recordings = []
    for name, effects in (("with", [bias]), ("plain", [])):
        make_case(tmp_path / name, "hinge", effects, 5, **SHORT)
        recordings.append(read(tmp_path / name)[0])
    biased, plain = recordings
    h = Hypothesis(EFFECTS["gyro_bias"], "imu2")
    fit = with_noise(refit(nominal_fit(biased, check_samples(biased).masks), (h,), steps=12))
    imu, other = biased.imu("imu2"), plain.imu("imu2")
    truth = deg(inclination(imu.time, imu.gyro, imu.accel), inclination(other.time, other.gyro, other.accel))
    filtered = OrdinaryEstimates.of(fit)
    assert filtered.shift([h])["orientation"] == pytest.approx([0.0, truth], rel=0.1)
    assert filtered.chance([h])["orientation"][1] < 0.1 * truth  # a bias that 8 s fix well
    off, known = filtered.std["orientation"][1], filtered.farther_off([h])["orientation"].value
    assert known == pytest.approx([0.0, np.hypot(off, truth) - off], rel=0.15)


def test_matched_rates_say_how_far_a_mount_is_turned(tmp_path):
    """A bias turns no mount by more than it is of the rates' RMS; a mount that is turned is off by that."""
    turned = ("mount_pose", "imu1", {"rotation": [0.03, -0.02, 0.04], "translation": [0.0, 0.0, 0.0]})
    make_case(tmp_path / "r", "free", [turned, ("gyro_bias", "imu1", {"bias": [0.0, 0.02, 0.01]})], 5, **SHORT)
    recording = read(tmp_path / "r")[0]
    bias, mount = (Hypothesis(EFFECTS[name], "imu1") for name in ("gyro_bias", "mount_pose"))
    fit = with_noise(refit(nominal_fit(recording, check_samples(recording).masks), (bias, mount), steps=12))
    ordinary = OrdinaryEstimates.of(fit)
    size = np.linalg.norm(fit.state.values["mount_pose@imu1.rotation"])
    assert ordinary.shift([mount])["mount_rotation"] == pytest.approx([np.degrees(size)], rel=0.1)
    rate = np.sqrt(np.mean(np.sum(recording.imu("imu1").gyro ** 2, axis=1)))
    assert ordinary.shift([bias])["mount_rotation"][0] < np.degrees(np.hypot(0.02, 0.01) / rate)

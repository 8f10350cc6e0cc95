"""A round of trials, on recordings of the independent generator."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.criteria.trial import Gain, Trial
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search import rounds
from imubench.diagnosis.search.moves.add import dated, heard_first
from imubench.diagnosis.search.rounds import try_round
from imubench.diagnosis.search.selected import candidates
from imubench.diagnosis.search.selection import select
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.effects.mounts import LONGEST
from imubench.format1 import read
from imubench.proof.case import make_case

SLIP = {"rotation": [0.0, 0.15, 0.05], "translation": [0.004, 0.0, 0.0], "time": 5.3}


@pytest.mark.slow
def test_all_that_a_round_tries_is_held_against_one_another_on_the_same_samples(tmp_path):
    """How a mount slips is not known: those samples are left out of what is beside it too, and of the fit without."""
    effects = [("mount_shift", "imu2", SLIP), ("gyro_bias", "imu1", {"bias": [0.03, -0.02, 0.02]})]
    make_case(tmp_path / "case", "hinge", effects, 71, seconds=10.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    some = [h for h in candidates(fit.model) if h.name in ("mount_shift@imu2", "gyro_bias@imu1", "accel_bias@imu2")]
    now = try_round(fit, some, lambda _: None)
    best = now.tried[0]
    assert best.hypothesis.name == "mount_shift@imu2"
    time = best.fit.state.values[best.hypothesis.key("time")][0] + fit.model.start
    assert time == pytest.approx(SLIP["time"], abs=LONGEST)
    assert len(now.tried) > 1
    for tried in (now.fit, now.first, *(t.fit for t in now.tried[1:])):
        masks = tried.model.masks or {}
        for sensor in ("imu1", "imu2"):
            stamps = fit.model.stamps[f"{sensor}.gyro"]
            left_out = stamps[~masks.get(f"{sensor}.gyro", np.ones(len(stamps), dtype=bool))]
            assert (len(left_out) > 0) == (sensor == "imu2")
            assert np.all(np.abs(left_out - time) < 1.5 * LONGEST)
    assert fit.model.masks is None  # what came in is as it was


def test_states_that_come_in_first_are_at_the_noise_that_they_leave(tmp_path, monkeypatch):
    """Beside springs at twice the noise power that they leave all refits seemed to lose, and nothing was found."""
    make_case(tmp_path / "case", "hinge", [], 73, seconds=4.0, rate=50.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    far = refit(replace(fit, noise={n: 4 * std for n, std in fit.noise.items()}), fit.model.hypotheses)
    springs = Trial(Hypothesis(EFFECTS["soft_mount"], "imu1"), far, 1e4)
    monkeypatch.setattr(rounds, "dynamic_trials", lambda *_: [springs])
    now = try_round(fit, [springs.hypothesis], lambda _: None)
    assert now.tried[0] is springs
    for name in ("imu1.gyro", "imu1.accel", "imu2.gyro", "imu2.accel"):
        assert now.first.noise[name] == pytest.approx(fit.noise[name], rel=0.15)


@pytest.mark.long
def test_a_slip_needs_recording_before_and_after_it(tmp_path):
    make_case(tmp_path / "case", "hinge", [], 72, seconds=6.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    h = next(h for h in candidates(fit.model) if h.name == "mount_shift@imu1")

    def at(time):
        class Fitted:
            span = (0.0, 6.0)
            state = type("S", (), {"values": {h.key("time"): np.array([time])}})

        return dated(Fitted, h)

    assert at(3.0)
    assert not at(0.01)
    assert not at(5.99)


@pytest.mark.parametrize(
    ("evidence", "humming", "first"), [(154, {"imu1"}, "imu1"), (140, {"imu1"}, "imu2"), (154, {}, "imu2")]
)
def test_a_hum_is_rather_where_the_samples_hum(evidence, humming, first):
    def trial(at, nat):
        return Trial(Hypothesis(EFFECTS["vibration"], at), None, nat)

    tried = heard_first([trial("imu2", 155.0), trial("imu1", evidence)], humming)
    assert [t.hypothesis.at for t in tried] == [first, *({"imu1", "imu2"} - {first})]


STEADY = {"rate": 200.0, "rate2": 128.0, "band": 2.3, "vigour": 0.77, "gyro_noise": 0.0011, "accel_noise": 0.0122}
FAINT = {"rotation": [0.0, 0.0, -0.0012], "translation": [-1.5e-4, 2.5e-4, -1.5e-4], "time": 7.4}


@pytest.mark.slow
def test_a_slip_that_shows_in_its_moment_alone_is_found_by_that(tmp_path):
    """No block of seconds tells of it in another; 0.3 mm and 1.2 mrad, by what its law says of 0.2 s."""
    make_case(tmp_path / "r", "hinge", [("mount_shift", "imu1", FAINT)], 20261126, seconds=15.0, **STEADY)
    found = select(nominal_fit(read(tmp_path / "r")[0]))
    assert [k.hypothesis.name for k in found.kept] == ["mount_shift@imu1"]
    louder, stamps = found.fit.model.louder, found.fit.model.stamps["imu1.accel"] + found.fit.model.start
    doubted = stamps[louder["imu1.accel"] > 1]  # by the end: its numbers are not read off its course alone
    assert doubted[0] < FAINT["time"] < doubted[-1] < FAINT["time"] + 2 * LONGEST


@pytest.mark.slow
def test_samples_that_a_refused_slip_left_out_count_again(tmp_path, monkeypatch):
    """What comes in beside it is fitted to all samples; a slip may be a loud moment of something else."""
    make_case(tmp_path / "case", "hinge", [("mount_shift", "imu2", SLIP)], 71, seconds=8.0)
    fit = nominal_fit(read(tmp_path / "case")[0])
    masks = []

    def nothing(before, after, rng):
        masks.append(before.model.masks)
        return Gain(-1.0, -2.0, 0.0, np.zeros(8))

    for name in ("heldout_gain", "by_halves"):
        monkeypatch.setattr(f"imubench.diagnosis.search.admission.{name}", nothing)
    found = select(fit)
    assert any(m is not None for m in masks)  # beside the slip
    assert found.kept == ()
    assert found.fit.model.masks is None

"""MuJoCo beside a recording: how far the declared and the found model are from samples they did not learn from."""

import json
from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.budget import Budget
from imubench.diagnosis.evidence import Evidence
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.residual_checks import fit_summary
from imubench.diagnosis.residual_checks.localize import locate
from imubench.diagnosis.result import Diagnosis, FitQuality, SimulatedChannel, Simulation
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.diagnosis.simulation.beside import as_smooth, beside, motion_of, with_levels
from imubench.diagnosis.simulation.channels import channels, simulated
from imubench.diagnosis.simulation.judge import cut_by
from imubench.diagnosis.simulation.learned import half_at, half_way, learned, parts_of
from imubench.diagnosis.simulation.sim_model import sim_model
from imubench.diagnosis.simulation.step import UNPLAYED, judged_by_simulation
from imubench.diagnosis.solve.refit import refit
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.format1 import read
from imubench.proof.case import build, make_case
from imubench.proof.excess import excess


def fitted(recording, effects=()):
    """Return the declared model's fit, that with some effects, and the noise that both are beside."""
    first = nominal_fit(recording)
    named = tuple(Hypothesis(EFFECTS[name], at) for name, at in effects)
    best = with_noise(refit(first, named)) if named else first  # as the search leaves a fit: its equation held closely
    noise = {f"{i.name}.{part}": std for i in recording.imus
             for part, std in (("gyro", i.gyro_noise_std), ("accel", i.accel_noise_std))}  # fmt: skip
    return first, best, noise | {"encoder.angle": 4e-5}


@pytest.fixture
def made(tmp_path):
    def make(rig, effects, seed, **options):
        make_case(tmp_path / "r", rig, effects, seed, **options)
        return read(tmp_path / "r")[0]

    return make


def over_noise(found):
    return {n: (c.before / c.noise, c.after / c.noise) for n, c in found.simulation.channels.items()}


@pytest.mark.long
def test_friction_that_was_found_is_what_the_declared_arm_lacks(swung):
    recording = swung({"dry_friction": 0.02, "viscous_friction": 0.002})
    effects = (("dry_friction", "joint"), ("viscous_friction", "joint"))
    first, best, noise = fitted(recording, effects)
    found = beside(recording, first, best, noise, {})
    assert found.simulation.how == "rolled out" and found.simulation.heldout
    (channel,) = found.simulation.channels.values()
    assert channel.before > 0.1  # rad: friction that stops the arm within half a minute
    assert channel.after < 0.02 * channel.before  # learned on one half, rolled out over seconds on the other
    (shown,) = found.channels
    assert shown.channel == "encoder.hinge" and shown.held_out
    np.testing.assert_array_equal(shown.measured, recording.encoders[0].angle)
    assert set(found.findings) == set(effects)
    for (of,) in found.findings.values():
        lacks, has = (np.sqrt(np.mean((x - of.measured) ** 2)) for x in (of.before, of.after))
        assert lacks > 3 * has  # each of them alone is needed


@pytest.mark.long
def test_a_swing_that_is_declared_beyond_the_samples_is_replayed_to_the_last_of_them(swung):
    """A model/ on disk refuses a swing without samples."""
    recording = swung({"dry_friction": 0.02}, 6.0)
    first, last = (float(recording.encoders[0].time[i]) for i in (0, -1))
    recording = replace(recording, free_swings=((first - 0.01, last + 0.01),))
    declared, best, noise = fitted(recording, (("dry_friction", "joint"),))
    (window,) = beside(recording, declared, best, noise, {}).windows
    assert (window.start, window.end) == (first, last)


def test_numbers_are_judged_where_they_were_not_learned(swung):
    """Half the arm's swing with other friction than the other half: no half foretells the other."""
    one, other = (swung({"dry_friction": t}, 4.0, seed=1) for t in (0.01, 0.05))
    encoder, later = one.encoders[0], other.encoders[0]
    time = np.concatenate([encoder.time, later.time + 4.0])
    both = replace(encoder, time=time, angle=np.concatenate([encoder.angle, later.angle]))
    swings = ((0.0, 3.99), (4.01, 7.99))
    recording = replace(one, encoders=(both,), free_swings=swings)
    best = fitted(recording, (("dry_friction", "joint"),))[1]
    halves = learned(best, parts_of(recording, swings))
    key = "dry_friction@joint.t"
    told = [float(half.fit.state.values[key][0]) for half in halves]
    assert told[0] == pytest.approx(0.05, rel=0.2)  # for judging the first swing, from the second
    assert told[1] == pytest.approx(0.01, rel=0.4)


@pytest.mark.long
@pytest.mark.parametrize(
    ("rig", "options"), [("hinge", {"base": "fixed", "seconds": 14.0}), ("pendulum", {"seconds": 20.0})]
)
def test_a_torque_shows_in_a_roll_out_and_is_gone_with_what_was_found(made, rig, options):
    recording = made(rig, [("viscous_friction", "joint")], 3, swing=True, **options)
    first, best, noise = fitted(recording, (("viscous_friction", "joint"),))
    found = beside(recording, first, best, noise, {})
    assert found.simulation.how == "rolled out" and found.simulation.heldout
    off = over_noise(found)
    last = f"imu{len(recording.imus)}"
    assert max(before for name, (before, _) in off.items() if name.startswith(f"{last}.gyr")) > 50
    assert all(after < 3 for _, after in off.values()), off  # 1 of noise, the rest of numbers from half the recording
    where = locate(found.added, {}, noise=0.0)
    # friction slows the swing itself: by far most of it is in the gyroscope of the sensor that swings
    assert where[0].at == last and next(iter(where[0].channels)).startswith("gyr")
    assert sum(share for name, share in where[0].channels.items() if name.startswith("gyr")) > 0.9


@pytest.mark.long
def test_what_an_effect_adds_is_in_its_own_sensor_alone(made):
    recording = made("hinge", [("gyro_scale", "imu2")], 4, seconds=8.0)
    first, best, noise = fitted(recording, (("gyro_scale", "imu2"),))
    found = beside(recording, first, best, noise, {})
    size = {trace.name: float(np.sqrt(np.mean(trace.whitened**2))) for trace in found.added}
    assert size.pop("imu2.gyro") > 1  # of the noise: twice as it is drawn
    assert max(size.values()) < 1e-6  # one motion and one set of mounts: nothing else reads anything else


@pytest.mark.long
def test_a_clean_swing_is_at_the_noise_before_and_after(made):
    recording = made("hinge", [], 5, seconds=12.0, base="fixed", swing=True)
    first, best, noise = fitted(recording)
    found = beside(recording, first, best, noise, {})
    assert found.simulation.how == "rolled out" and found.simulation.heldout
    for before, after in over_noise(found).values():
        assert before == after and 0.9 < after < 1.2  # of the noise as it is drawn; 1,000 samples a channel


@pytest.mark.long
def test_a_spring_rings_by_its_law_where_a_hand_moves_the_rig(made):
    shape = {"frequency": [7.0, 8.0, 9.0], "damping_ratio": 0.1}
    recording = made("hinge", [("soft_mount", "imu2", shape)], 4, seconds=8.0, vigour=2.0, band=6.0)
    first, best, noise = fitted(recording, (("soft_mount", "imu2"),))
    found = beside(recording, first, best, noise, {})
    assert found.simulation.how == "prescribed" and found.simulation.windows_s[0][0] == recording.imus[0].time[0]
    off = over_noise(found)
    # over the noise: the motion that is prescribed takes most of the ringing; springs and motion are of half of 8 s
    for name, (before, after) in ((n, o) for n, o in off.items() if ".acc" in n):
        assert before > 1.3 and after < 1.3, (name, before, after)
    assert {c.channel.split(".")[0] for c in found.findings["soft_mount", "imu2"]} <= {"imu1", "imu2"}


@pytest.mark.long
def test_a_spring_is_replayed_from_a_motion_that_obeys_its_law(made):
    """A search may let a spring be off its law by metres per second squared; MuJoCo's obeys it, and rings with that."""
    shape = {"frequency": [14.0, 16.0, 18.0], "damping_ratio": 0.1}
    recording = made("hinge", [("soft_mount", "imu2", shape)], 4, seconds=8.0, vigour=2.0, band=6.0)
    first, best, noise = fitted(recording, (("soft_mount", "imu2"),))
    loose = with_levels(best, {"soft_mount@imu2.balance": 30.0})  # of 0.1 m/s^2
    model = sim_model(loose)
    accel = recording.imu("imu2").accel

    def off(motion):
        read = simulated(replace(model, motion=motion), recording, ()).channels
        played = np.stack([read[f"imu2.acc_{axis}"] for axis in "xyz"], axis=1)
        return float(np.sqrt(np.mean((played - accel)[100:] ** 2))) / noise["imu2.accel"]  # settled after 1 s

    strict = off(motion_of(loose, as_smooth(first, loose)[1], recording))
    assert strict < 1.0  # of the noise: the motion takes some of it
    assert off(fit_summary.played(loose)) > 1.2 * strict


OFF = {"gyro_scale": {"scale": [0.03, -0.02, 0.03]}, "time_offset": {"offset": -0.012}, "clock_skew": {"skew": 1e-3}}


@pytest.mark.long
@pytest.mark.parametrize("effect", OFF)
def test_a_replay_is_as_near_as_the_fit_that_it_replays(effect, made):
    """With a hand's motion prescribed MuJoCo reads what the fit's own laws read, half by half.

    The first and last samples too: what a clock that is off reads there was before the first stamp or after the last.
    """
    recording = made("hinge", [(effect, "imu2", OFF[effect])], 6, seconds=8.0)
    first, best, noise = fitted(recording, ((effect, "imu2"),))
    channels_ = beside(recording, first, best, noise, {}).simulation.channels
    for name, c in channels_.items():
        # quintics through the motion's rows, and the six digits of a rig: a hundredth of the noise
        assert c.after == pytest.approx(c.fit, rel=0.02, abs=0.01 * c.noise), name
    assert max(c.before / c.fit for c in channels_.values()) > 1.5


@pytest.mark.long
def test_the_declared_simulation_has_no_clock_that_the_search_begins_with(made):
    """A clock 30 ms off is in the first fit already. What the generator says of it must show all the same."""
    clock = ("time_offset", "imu2", {"offset": 0.03})
    recording = made("hinge", [clock], 6, seconds=8.0)
    first, best, noise = fitted(recording, (("time_offset", "imu2"),))
    assert first.model.judged  # else this asks nothing
    found = beside(recording, first, best, noise, {}).simulation.channels
    told = excess(build("hinge", [clock], 6, seconds=8.0))
    name = max(told, key=lambda n: told[n].left / told[n].noise)
    grown = np.sqrt(found[name].before ** 2 - found[name].after ** 2)
    # nonlinear at 30 ms: the motion that is left over turns segment 2 by up to 0.1 rad
    assert grown == pytest.approx(told[name].left, rel=0.25)


def test_a_number_that_one_half_alone_can_tell_is_not_called_held_out(swung):
    """An arm that hangs still in its second half says nothing of friction there."""
    recording = swung({"viscous_friction": 0.05}, 9.0)
    best = fitted(recording, (("viscous_friction", "joint"),))[1]
    halves = learned(best, parts_of(recording, ((0.0, 4.0), (6.0, 8.9))))
    assert not halves[0].held_out


def test_a_single_swing_is_cut_where_half_of_its_motion_is_over(swung):
    recording = swung({"dry_friction": 0.1}, 9.0)
    swing = recording.free_swings[0]
    first, second = parts_of(recording, (swing,))
    assert (first.half, second.half) == (0, 1) and first.end == second.start < sum(swing) / 2
    assert (first.start, second.end) == pytest.approx(swing)


def test_every_other_swing_is_of_one_half_and_what_is_between_is_cut(swung):
    recording = swung({}, 9.0)
    parts = parts_of(recording, ((1.0, 3.0), (4.0, 6.0), (6.5, 8.0)))
    swings = [p for p in parts if p.swings]
    assert [(p.start, p.end, p.half) for p in swings] == [(1.0, 3.0, 0), (4.0, 6.0, 1), (6.5, 8.0, 0)]
    assert sum(p.end - p.start for p in parts) == pytest.approx(float(np.ptp(recording.encoders[0].time)))
    assert half_at(parts, np.array([2.0, 5.0, 7.0])).tolist() == [0, 1, 0]


def test_a_body_that_never_moves_is_cut_in_the_middle():
    time = np.linspace(0.0, 10.0, 101)
    assert half_way(time, np.zeros(101), (2.0, 6.0)) == 4.0


def test_every_measured_channel_is_there_and_what_was_not_seen_is_not(good):
    recording = read(good)[0]
    names = [c.name for c in channels(recording)]
    assert len(names) == len(set(names))
    assert {"imu1.gyr_x", "imu1.acc_z"} <= set(names)
    for c in channels(recording):
        assert c.time.shape == c.measured.shape and np.isfinite(c.measured).all()


SIMULATION = Simulation(
    "rolled out", ((12.0, 31.5),), True, {"encoder.hinge": SimulatedChannel("rad", 0.44, 0.006, 0.0005)}
)


def test_a_simulation_is_written_and_read_back(tmp_path):
    said = Diagnosis("r", "hinge", "no mismatch", (1.0, 1.0), (), (), (), FitQuality((1.0, 1.0)), "", 1.0)
    said = replace(said, simulation=SIMULATION)
    (tmp_path / "diagnosis.json").write_text(json.dumps(as_dict(said)))
    assert read_diagnosis(tmp_path).simulation == SIMULATION
    told = replace(SIMULATION, channels={"encoder.hinge": SimulatedChannel("rad", 0.44, 0.006, 0.0005, 0.0004)})
    (tmp_path / "diagnosis.json").write_text(json.dumps(as_dict(replace(said, simulation=told))))
    assert read_diagnosis(tmp_path).simulation == told
    content = as_dict(said)
    assert content["simulation"] == {
        "how": "rolled out", "windows_s": [[12.0, 31.5]], "heldout": True,
        "channels": {"encoder.hinge": {"unit": "rad", "before": 0.44, "after": 0.006, "noise": 0.0005}},
    }  # fmt: skip


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"how": "guessed"}, "key 'simulation': unknown simulation.how 'guessed'"),
        ({"windows_s": [[2.0, 1.0]]}, "expected the lower end first"),
        ({"heldout": 1}, "key 'simulation.heldout': expected true or false"),
        ({"channels": {"foot.x": {"unit": "m", "before": 1, "after": 1, "noise": 1}}}, "simulation.channels.foot.x"),
        ({"channels": {"imu1.acc_x": {"unit": "m/s^2", "before": -1, "after": 1, "noise": 1}}}, "simulation.before"),
        (
            {"channels": {"imu1.acc_x": {"unit": "m/s^2", "before": 1, "after": 1, "noise": 1, "fit": -1}}},
            "simulation.fit",
        ),
    ],
)
def test_a_broken_simulation_is_refused_in_one_line(tmp_path, change, message):
    said = Diagnosis("r", "hinge", "no mismatch", (1.0, 1.0), (), (), (), FitQuality((1.0, 1.0)), "", 1.0)
    content = as_dict(replace(said, simulation=SIMULATION))
    content["simulation"] |= change
    (tmp_path / "diagnosis.json").write_text(json.dumps(content))
    with pytest.raises(InputError) as caught:
        read_diagnosis(tmp_path)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_diagnosis_whose_time_is_spent_says_that_nothing_was_played(swung):
    recording = swung({"dry_friction": 0.02}, 4.0)
    first, best, noise = fitted(recording)
    weighed = fit_summary.weighed(first, noise)
    evidence = Evidence(recording, fit_summary.traces(weighed), fit_summary.played(first), {}, weighed.levels)
    spent = Budget(limit=1e-9)
    simulation, same, acting = judged_by_simulation(evidence, first, best, (), {}, spent)
    assert simulation is None and same is evidence and acting == () and UNPLAYED in spent.not_tried


@pytest.mark.long
def test_a_diagnosis_has_the_simulation_and_what_shows_it(swung):
    recording = swung({"dry_friction": 0.02}, 9.0)
    said, evidence = diagnose(recording)
    assert said.simulation is not None and said.simulation.how == "rolled out"
    (channel,) = said.simulation.channels.values()
    assert channel.after < 0.1 * channel.before
    assert [c.channel for c in evidence.simulated] == ["encoder.hinge"]
    assert len(evidence.comparisons) == len(said.findings)
    (window,) = evidence.rolled_out
    assert (window.start, window.end) == pytest.approx(recording.free_swings[0])


@pytest.mark.parametrize(
    ("horizon", "cut"),
    [(20.0, 20.0), (4.0, 4.0), (18.0, 18.0), (19.0, 18.5), (1.6, 1.6)],  # at least 1.5 s are left, or nothing
)
def test_a_window_is_cut_by_its_horizon_and_leaves_no_remnant(horizon, cut):
    assert cut_by(horizon, 0.0, 20.0) == cut


def test_a_stretch_that_is_too_short_for_two_windows_is_one():
    assert cut_by(1.6, 0.0, 2.5) == 2.5


def test_a_sensor_of_which_no_sample_counts_is_not_judged(hardly_counting):
    """As an accelerometer that clips below the weight: all its samples are masked."""
    fit = hardly_counting(0)
    noise = {rows.name: 1.0 for rows in fit.measured}
    assert "imu2.accel" not in noise
    found = beside(fit.model.recording, fit, fit, noise, {})
    parts = [f"{part}_{axis}" for part in ("gyr", "acc") for axis in "xyz"]
    assert set(found.simulation.channels) == {f"imu1.{part}" for part in parts} | {f"imu2.{p}" for p in parts[:3]}

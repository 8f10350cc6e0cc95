"""What the simulations of hand-made diagnoses are worth: modelled, shown, pointed at; and what must not pass."""

import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import tomli_w

from imubench.answers import write_json
from imubench.diagnosis.result import (
    Diagnosis,
    Finding,
    FitQuality,
    Interval,
    Parameter,
    SimulatedChannel,
    Simulation,
    Where,
)
from imubench.diagnosis.result_file import as_dict
from imubench.inputs.toml import load_toml
from imubench.proof.excess import Excess, excess
from imubench.proof.told import truth as told_of
from imubench.sim.rigs import Slip, hinge
from imubench.trials import blind
from imubench.trials.counted import FIGURES
from imubench.trials.judge import ALARM, with_replays
from imubench.trials.make import answers, rebuilt
from imubench.trials.replayed import (
    MODEL,
    SEEN,
    Replayed,
    nearness,
    on_disk,
    pointed,
    replayed,
    shown,
    slipping,
    stated,
)
from imubench.trials.report_cases import FAILURES, cases
from imubench.trials.scoring import score
from tests.concealed import concealed, finding

SCALE = {"scale": [0.03, 0.02, -0.03]}
NAMES = [f"imu{i}.{kind}_{axis}" for i in (1, 2) for kind in ("gyr", "acc") for axis in "xyz"]


def simulation(how="prescribed", heldout=True, windows=((0.0, 10.0),), **channels):
    return Simulation(how, windows, heldout, {name.replace("__", "."): c for name, c in channels.items()})


def channel(before, after, noise=1.0, fit=1.0):
    return SimulatedChannel("rad/s", before, after, noise, fit)


def said(*findings, where=(), **kwargs):
    verdict = "explained" if findings else "no mismatch"
    return Diagnosis(
        "r", "hinge", verdict, (5.0, 1.0), tuple(where), findings, (), FitQuality((5.0, 1.0)), "", 1.0, **kwargs
    )


def at(place, *channels):
    return Where(place, dict.fromkeys(channels, 0.5), (), (), "", 1.0)


@pytest.fixture(scope="module")
def scaled(tmp_path_factory):
    """A gyroscope's scale at imu2 of a hinge; the model on disk is the truth."""
    folder = tmp_path_factory.mktemp("scaled")
    return concealed(folder, "hinge", [("gyro_scale", "imu2", SCALE)])


def truth_of(case, kind="one"):
    """The truth as a trial opens it."""
    effects = case.effects
    return told_of(case) | {
        "kind": kind,
        "observable": True,
        "answers": [answers(e, case.options) for e in effects],
        "freedom": [3 for _ in effects],
        "visibility": [50.0 for _ in effects],
        "bounds": [None for _ in effects],
    }


def answered(found, folder, after=1.0, before=4.0, **kwargs):
    """A right diagnosis of a case in a folder of its own; its simulation over the noise in every channel."""
    noise = {"gyr": found.recording.imus[1].gyro_noise_std, "acc": found.recording.imus[1].accel_noise_std}
    every = {n: channel(before * s, after * s, s, s) for n in NAMES for s in [noise[n.split(".")[1][:3]]]}
    told = tuple(finding(e.effect, e.at, e.parameters) for e in found.case.effects)
    d = said(*told, simulation=Simulation("prescribed", ((0.0, 10.0),), True, every), **kwargs)
    folder.mkdir(parents=True)
    write_json(folder / "diagnosis.json", as_dict(d))
    shutil.copytree(found.folder, folder / MODEL)
    return d


def test_a_replay_is_held_against_what_the_fit_leaves():
    """Over channels of different noise, in units of each: (4 + 1) / (1 + 1), and 1.1^2 in the worst channel."""
    both = simulation(imu1__gyr_x=channel(9.0, 2.0), imu2__acc_x=channel(0.9, 0.1, noise=0.1, fit=0.1))
    assert nearness(both, {"imu1.gyr_x": 1.1, "imu2.acc_x": 0.1}) == pytest.approx((2.5, 1.1**2))
    looser = {"imu1.gyr_x": 0.5, "imu2.acc_x": 0.12}  # one channel far below makes up for nothing
    assert nearness(both, looser) == pytest.approx((2.5, 1.2**2))
    assert nearness(both, {"imu1.gyr_x": 1.1}) == pytest.approx((2.5, None))  # the model does not play every channel
    assert nearness(None, {"imu1.gyr_x": 1.0}) == (None, None)
    untold = simulation(imu1__gyr_x=channel(9.0, 2.0, fit=None))
    assert nearness(untold, {"imu1.gyr_x": 1.0}) == (None, None)


def test_a_roll_out_is_held_against_samples_that_the_fit_did_not_follow():
    """A fit's motion takes up a third of the noise: a roll-out with the true numbers is at the noise, and near."""
    true = simulation(
        imu1__gyr_x=channel(9.0, 1.0, fit=np.sqrt(2 / 3)), imu2__acc_x=channel(9.0, 1.0, fit=np.sqrt(2 / 3))
    )
    disk = dict.fromkeys(("imu1.gyr_x", "imu2.acc_x"), 1.0)
    assert nearness(true, disk, heldout=1.0) == pytest.approx((1.0, 1.0))
    assert nearness(true, disk) == pytest.approx(
        (1.5, 1.5)
    )  # prescribed to the fit's motion it would be half the noise off
    worse = simulation(imu1__gyr_x=channel(9.0, 1.2, fit=np.sqrt(2 / 3)))
    assert nearness(worse, {"imu1.gyr_x": 1.2}, heldout=1.0) == pytest.approx((1.44, 1.0))  # on disk is what was judged
    assert nearness(true, disk | {"imu1.gyr_x": 1.2}, heldout=1.0) == pytest.approx((1.0, 1.44))  # and here it is not


def test_shown_is_asked_in_the_channel_where_a_motion_hides_least():
    told = {"imu2.gyr_x": Excess(9.0, 0.5, 1.0, 1000), "imu2.acc_x": Excess(0.3, 0.3, 0.1, 1000)}
    off = simulation(imu2__gyr_x=channel(5.0, 1.0), imu2__acc_x=channel(0.35, 0.12, noise=0.1, fit=0.1))
    name, share = shown(off, told)  # 3 times the noise beats half of it, however much was concealed
    assert name == "imu2.acc_x" and share == pytest.approx(np.sqrt(0.35**2 - 0.12**2) / 0.3)
    assert shown(None, told) == ("imu2.acc_x", None)
    assert shown(simulation(imu2__gyr_x=channel(5.0, 1.0)), told) == ("imu2.acc_x", None)


def test_a_simulation_that_is_as_far_off_before_as_after_shows_nothing():
    told = {"imu2.gyr_x": Excess(2.0, 2.0, 1.0, 1000)}
    assert shown(simulation(imu2__gyr_x=channel(2.2, 2.2)), told) == ("imu2.gyr_x", 0.0)
    assert shown(simulation(imu2__gyr_x=channel(1.0, 2.2)), told) == ("imu2.gyr_x", 0.0)  # worse than that


def test_what_no_test_of_the_samples_could_see_need_not_show():
    faint = 0.99 * SEEN / np.sqrt(1000)
    assert shown(simulation(), {"imu2.gyr_x": Excess(2.0, faint, 1.0, 1000)}) == ("", None)
    assert shown(simulation(), {}) == ("", None)


def test_an_effect_that_shows_at_the_limit_passes_half_of_it_998_times_in_1000():
    """The reason of `SEEN`: before is noise and effect, after is noise, and the half is three deviations away."""
    rng, n, left = np.random.default_rng(1), 1000, SEEN / np.sqrt(1000)
    wave = left * np.sqrt(2) * np.sin(np.arange(n))
    passed = []
    for _ in range(4000):
        noise = rng.standard_normal(n)
        before, after = (float(np.sqrt(np.mean(x**2))) for x in (noise + wave, noise))
        off = simulation(imu2__gyr_x=channel(before, after))
        passed.append(shown(off, {"imu2.gyr_x": Excess(left, 1.0001 * left, 1.0, n)})[1] >= 0.5)
    assert np.mean(passed) == pytest.approx(0.9987, abs=0.002)  # three standard errors of 4000 draws


@pytest.mark.parametrize(
    ("where", "right"),
    [
        ((at("imu2", "gyr_x"),), (True, True)),
        ((at("imu2", "gyr_z"),), (True, False)),  # a tenth of the largest
        ((at("imu2", "acc_x"),), (True, False)),
        ((at("imu1", "gyr_x"), at("imu2", "gyr_x")), (False, False)),
        ((at("encoder", "angle"),), (False, False)),
        ((), (False, False)),
    ],
)
def test_the_first_of_where_is_held_against_what_was_concealed(where, right):
    told = {n: Excess(0.0, 1.0, 1.0, 100) for n in NAMES}  # a motion carries it everywhere
    told |= {"imu2.gyr_x": Excess(5.0, 1.0, 1.0, 100), "imu2.gyr_z": Excess(0.5, 1.0, 1.0, 100)}
    lone = {"answers": [[{"effect": "gyro_scale", "at": "imu2"}]]}
    assert pointed(lone, said(where=where), told) == right


def test_of_an_effect_in_the_rig_every_sensor_is_right_that_it_moves():
    told = {"imu1.gyr_x": Excess(0.1, 1.0, 1.0, 100), "imu2.gyr_x": Excess(5.0, 1.0, 1.0, 100)}
    joint = {"answers": [[{"effect": "axis_coupling", "at": "joint"}]]}
    found = {w: pointed(joint, said(where=(at(w, "gyr_x"),)), told) for w in ("imu1", "imu2", "joint", "encoder")}
    assert found == {"imu1": (False, False), "imu2": (True, True), "joint": (True, True), "encoder": (True, True)}


def test_without_a_mean_only_the_sensor_is_asked():
    noisy = {"answers": [[{"effect": "gyro_noise", "at": "imu2"}]]}
    assert pointed(noisy, said(where=(at("imu2", "gyr_x"),)), {}) == (True, None)


def test_a_true_model_on_disk_is_modelled_and_shown(scaled, tmp_path):
    truth = truth_of(scaled.case)
    where = (at("imu2", "gyr_x"),)
    known = excess(scaled.case)
    d = answered(scaled, tmp_path / "answer", where=where)
    r = replayed(truth, d, tmp_path / "answer", scaled.folder.parent / "recording")
    # the worst of 12 channels of 1,000 samples: 4.5 % each, 1.6 of these on average
    assert r.replay == pytest.approx(1.0) and r.disk == pytest.approx(1.07, abs=0.07)
    assert (r.modelled, r.shown, r.held_out, r.rolled_out) == (True, True, True, False)
    most = known[r.channel]
    assert r.showed == pytest.approx(np.sqrt(4.0**2 - 1.0) * most.noise / most.left)
    assert r.sensor and known[r.channel].left == pytest.approx(
        max(x.left / x.noise for x in known.values()) * most.noise
    )


def test_a_model_on_disk_with_another_number_is_not_modelled(scaled, tmp_path):
    """diagnosis.json says that its replay is near; what was written is not what was judged."""
    d = answered(scaled, tmp_path / "answer")
    file = tmp_path / "answer" / MODEL / "imus.toml"
    content = load_toml(file)
    (effect,) = content["effect"]
    effect["parameters"]["scale"] = [0.0, 0.0, 0.0]
    file.write_text(tomli_w.dumps(content))
    r = replayed(truth_of(scaled.case), d, tmp_path / "answer", scaled.folder.parent / "recording")
    assert r.replay == pytest.approx(1.0) and r.disk > 2 and r.modelled is False


@pytest.mark.parametrize("broken", ["gone", "damaged"])
def test_without_a_model_on_disk_nothing_is_modelled(broken, scaled, tmp_path):
    d = answered(scaled, tmp_path / "answer")
    file = tmp_path / "answer" / MODEL / "imus.toml"
    file.unlink() if broken == "gone" else file.write_text("format = 2\n")
    r = replayed(truth_of(scaled.case), d, tmp_path / "answer", scaled.folder.parent / "recording")
    assert (r.disk, r.modelled) == (None, False)


def test_a_replay_farther_off_than_its_fit_is_not_modelled(scaled, tmp_path):
    d = answered(scaled, tmp_path / "answer", after=1.06)  # 1.12 in power
    r = replayed(truth_of(scaled.case), d, tmp_path / "answer", scaled.folder.parent / "recording")
    assert r.replay == pytest.approx(1.1236) and r.modelled is False and r.shown is True


def test_a_spring_that_does_not_obey_its_law_is_not_modelled_for_its_replay_does(scaled, tmp_path):
    """Fit and replay are as far off, both held to the law; the fit of the diagnosis is not, and says 1.0 held out."""
    d = answered(scaled, tmp_path / "answer")
    every = {n: replace(c, after=1.3 * c.noise, fit=1.3 * c.noise) for n, c in d.simulation.channels.items()}
    d = replace(d, simulation=replace(d.simulation, channels=every))
    r = replayed(truth_of(scaled.case), d, tmp_path / "answer", scaled.folder.parent / "recording")
    assert r.replay == pytest.approx(1.0) and r.disk < 1.1 and r.modelled is False


def test_a_wrong_name_is_asked_only_where_it_points(scaled, tmp_path):
    d = answered(scaled, tmp_path / "answer", where=(at("imu1", "gyr_x"),))
    wrong = replace(d, findings=(finding("gyro_scale", "imu1", SCALE),))
    r = replayed(truth_of(scaled.case), wrong, tmp_path / "answer", scaled.folder.parent / "recording")
    assert r == Replayed(sensor=False, first_channel=False)
    assert replayed(truth_of(scaled.case), said(), tmp_path / "answer", tmp_path) == Replayed()  # nothing was found
    assert replayed(truth_of(scaled.case) | {"observable": False}, d, tmp_path, tmp_path) == Replayed()


def test_samples_that_do_not_count_are_left_out_on_disk(scaled, tmp_path):
    """Over half of the recording's windows there are half of the samples, and no other's error."""
    d = answered(scaled, tmp_path / "answer")
    recording = scaled.folder.parent / "recording"
    whole, first = (
        on_disk(scaled.folder, recording, replace(d.simulation, windows_s=((0.0, end),))) for end in (10.0, 5.0)
    )
    assert set(whole) == set(first) == set(NAMES) and whole != first
    assert on_disk(tmp_path / "nowhere", recording, d.simulation) == {}


def test_the_moment_in_which_a_sensor_slips_is_left_out_of_its_own_channels():
    rig = hinge()
    rig = replace(rig, mounts=(rig.mounts[0], replace(rig.mounts[1], slip=Slip(12.0, [0.002, 0, 0], [0, 0.03, 0]))))
    model = SimpleNamespace(rig=rig, start=100.0)
    ((start, end),) = slipping(model, "imu2.gyro")
    assert 111.7 < start < 112.0 and 112.2 < end < 112.5  # the change takes a fifth of a second
    assert slipping(model, "imu1.accel") == []


def test_a_case_is_built_again_from_its_truth(scaled):
    again = rebuilt(truth_of(scaled.case))
    assert np.array_equal(again.imus[1].gyro, scaled.case.imus[1].gyro)


@pytest.mark.long
def test_scores_are_completed_and_counted(scaled, tmp_path):
    truths = {"000": truth_of(scaled.case), "001": truth_of(scaled.case)}
    right = answered(scaled, tmp_path / "answers" / "000", where=(at("imu2", "gyr_x"),))
    answered(scaled, tmp_path / "answers" / "001", before=1.0, where=(at("imu1", "gyr_x"),))
    for name in truths:
        shutil.copytree(scaled.folder.parent / "recording", tmp_path / "cases" / name / "recording")
    scores = tuple(score(name, truths[name], right, 1.0, ALARM) for name in truths)
    calls = []
    done = with_replays(scores, truths, tmp_path / "answers", tmp_path / "cases", 1, lambda *seen: calls.append(seen))
    assert calls == [("replay models", 0, 2), ("replay models", 1, 2), ("replay models", 2, 2)]
    counted = {name: FIGURES[name](done)[1:] for name in ("modelled", "shown", "where_sensor", "where_channel")}
    assert counted == {"modelled": (2, 2), "shown": (2, 1), "where_sensor": (2, 1), "where_channel": (2, 1)}
    assert [FIGURES[name](done)[1] for name in ("modelled_several", "modelled_swings", "shown_several")] == [0, 0, 0]
    swung = [replace(s, kind="several", replayed=replace(s.replayed, rolled_out=True)) for s in done]
    assert [FIGURES[name](swung)[1] for name in ("modelled", "modelled_several", "modelled_swings")] == [0, 0, 2]
    page = cases(done)
    assert "replayed: 1 of the fit&#x27;s misfit" in page and "first sensor wrong, channel wrong" in page
    failed = {title: [s.name for s in done if is_one(s)] for title, is_one in FAILURES.items()}
    assert failed["Right name, but the declared simulation is not worse by what was concealed"] == ["001"]
    assert failed["Right name, but the replay is not as near as the fit"] == []
    assert failed["Found, but `where` has another sensor first"] == ["001"]


def test_no_link_is_followed_out_of_a_diagnosis(tmp_path):
    (tmp_path / "secret").write_text("seed")
    written = tmp_path / MODEL
    written.mkdir()
    (written / "imus.toml").write_text("format = 1\n")
    (written / "hinge.xml").symlink_to(tmp_path / "secret")
    blind.keep_model(written, tmp_path / "kept")
    assert [p.name for p in (tmp_path / "kept").iterdir()] == ["imus.toml"]
    (tmp_path / "whole").symlink_to(written)
    blind.keep_model(tmp_path / "whole", tmp_path / "kept")
    assert not (tmp_path / "kept").exists()  # what an earlier run left is gone, too


@pytest.mark.parametrize(
    ("effect", "name", "size", "left"), [("accel_noise", "std", 2.0, 2.0), ("quantisation", "step", 6.0, 2.0)]
)
def test_a_replay_is_held_against_the_noise_that_was_found(effect, name, size, left):
    """Louder noise and rounding, variance step^2 / 12 beside the noise's, are in the held-out misfit that is stated."""
    told = Parameter(np.array(size), np.array(0.01), "m/s^2")
    loud = Finding(effect, "imu2", 0.95, {name: told}, Interval(0.0, (0.0, 0.0)))
    channels = {"imu1__acc_x": channel(1.0, 1.0), "imu2__acc_x": channel(left, left)}
    assert stated(said(loud, simulation=simulation(**channels))) == pytest.approx(1.0)
    assert stated(said(simulation=simulation(**channels))) == pytest.approx((1 + left**2) / 2)

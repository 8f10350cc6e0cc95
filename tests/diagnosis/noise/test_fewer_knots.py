"""What a motion on fewer knots keeps, when it may have them, which springs need more, and what their numbers gain."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import make_lsq_spline

from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.config.noise import KNOT_SELECTION
from imubench.diagnosis.config.samples import NOISE_FLOOR
from imubench.diagnosis.criteria.effect_dynamics import driven_by_motion
from imubench.diagnosis.noise import knot_selection
from imubench.diagnosis.noise.coherence import clear_at
from imubench.diagnosis.noise.coloured import parameter_std
from imubench.diagnosis.noise.debias import law_parameters
from imubench.diagnosis.noise.debiased_fit import debiased, settled
from imubench.diagnosis.noise.declared_noise import declared
from imubench.diagnosis.noise.knot_selection import (
    coarser,
    coarsest,
    finer,
    knots_suffice,
    matrix,
    peaks,
    ringing,
    too_quick,
)
from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.noise.reml import with_noise
from imubench.diagnosis.problem.bspline import Knots
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.search.moves.dynamic_refits import calm_for_laws
from imubench.diagnosis.solve.gauss_newton import extended
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.effects import EFFECTS
from imubench.format1 import read
from imubench.proof.case import make_case


def test_the_matrix_of_a_spline_makes_its_values():
    knots = Knots.over(0.0, 2.0, 0.1)
    greville = knots.start + knots.step * (np.arange(knots.count) - 2)  # a quintic makes a straight line of these
    time = np.linspace(0.0, 2.0, 57)
    assert np.allclose(matrix(knots, time) @ greville, time)


@pytest.mark.long
def test_a_slow_motion_has_half_the_knots_or_less_and_is_the_same(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 5, seconds=8.0, band=1.5)
    fit = nominal_fit(read(tmp_path / "r")[0])
    few = coarsest(fit)
    assert few.model.tracks.knots.count < 0.6 * fit.model.tracks.knots.count
    time = np.linspace(0.5, 7.5, 400)
    columns = fit.model.tracks.columns("hinge")
    fine, rough = (matrix(f.model.tracks.knots, time) @ f.state.coefficients[:, columns] for f in (fit, few))
    assert np.ptp(fine) > 0.3
    assert np.std(fine - rough) < 2e-3  # where the joint is at zero nothing tells to less than some milliradians


def test_what_is_too_quick_for_fewer_knots_is_not_solved_on_them_and_would_not_do(tmp_path, monkeypatch):
    make_case(tmp_path / "r", "pendulum", [("soft_mount", "imu1")], 5, seconds=8.0, rate=50.0)
    fit, asked = nominal_fit(read(tmp_path / "r")[0]), []
    every = [times for times in KNOT_SELECTION.fewer if too_quick(fit, times * fit.model.tracks.knots.step)]
    assert every
    assert not any(knots_suffice(coarser(fit, times)) for times in every)
    monkeypatch.setattr(knot_selection, "coarser", lambda fit, times: asked.append(round(times)) or coarser(fit, times))
    coarsest(fit)
    assert not set(asked) & set(every)


@pytest.mark.long
def test_a_gap_makes_no_motion_look_quick(tmp_path):
    """Of 0.05 to 0.3 s without samples, on either IMU: the motion of 1.5 Hz on both sides of it is what it was."""
    found = []
    for gaps in (0, 1):
        make_case(tmp_path / f"{gaps}", "hinge", [], 5, seconds=8.0, band=1.5, gaps=gaps)
        fit = nominal_fit(read(tmp_path / f"{gaps}")[0])
        assert all(np.max(np.diff(imu.time)) > 0.03 for imu in fit.model.recording.imus) == bool(gaps)
        found.append([clear_at(fit, imu.name) for imu in fit.model.recording.imus])
    assert np.max(np.abs(np.subtract(*found))) <= 1.0  # of 7 Hz; with the gaps' steps in it 40
    assert coarsest(fit).model.tracks.knots.count < 0.6 * fit.model.tracks.knots.count


@pytest.mark.long
def test_a_search_begins_with_as_few_knots_as_the_motion_needs_though_a_sensor_is_wrong(tmp_path):
    make_case(tmp_path / "r", "hinge", [("gyro_scale", "imu2")], 7, seconds=12.0, band=1.5)
    recording = read(tmp_path / "r")[0]
    fit = begin(recording).fit
    assert fit.model.tracks.knots.count < 0.6 * nominal_fit(recording).model.tracks.knots.count
    assert coarsest(fit) is fit  # has them already, and nobody goes below the fewest


@pytest.mark.parametrize("count", [1, 3, 12, 30])
def test_so_few_samples_that_they_have_no_spectrum_keep_the_knots(hardly_counting, count):
    fit = hardly_counting(count)
    assert max(peaks(fit)) == np.inf
    assert coarsest(fit) is fit


def test_a_recording_without_an_imu_keeps_its_knots(tmp_path):
    make_case(tmp_path / "r", "free", [], 5, seconds=3.0, pose=True, band=1.0)
    fit = nominal_fit(replace(read(tmp_path / "r")[0], imus=()))
    assert not knots_suffice(fit)
    assert coarsest(fit) is fit


@pytest.mark.long
def test_slow_noise_needs_no_knots_and_quick_noise_does(tmp_path):
    """What the knots follow anyway, and what is left beyond them."""
    make_case(tmp_path / "r", "hinge", [], 5, seconds=8.0, band=1.5)
    few = coarsest(nominal_fit(read(tmp_path / "r")[0]))
    last = few.measured[-1]
    time = last.time
    for frequency, needed in ((1.0, False), (0.9 / (2 * few.model.tracks.knots.step), True)):
        hum = np.sin(2 * np.pi * frequency * time)[:, None]
        rows = [replace(r, residual=r.residual + hum * r.std) if r is last else r for r in few.rows]
        assert (max(peaks(replace(few, rows=rows))) > NOISE_FLOOR.steady_power) == needed


def test_a_hinge_on_a_wall_has_one_spline_and_keeps_it(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 5, seconds=4.0, band=1.5, base="fixed", encoder=True)
    fit = nominal_fit(read(tmp_path / "r")[0])
    few = coarser(fit, 2)
    assert few.state.coefficients.shape == (few.model.tracks.knots.count, 1)
    assert few.cost < 1.3 * fit.cost


@pytest.mark.long
def test_a_quick_motion_has_as_many_knots_as_it_needs(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 5, seconds=8.0, rate=50.0, band=12.0, vigour=1.5)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert coarsest(fit) is fit
    lost = coarser(fit, 4)  # 6 Hz at most
    assert not knots_suffice(lost)
    assert max(peaks(lost)) > 3


def sprung(tmp_path, name, seed, rig="hinge", **options):
    """Return the fit of a rig whose first IMU is on springs, begun a tenth too soft, and these springs' numbers."""
    truth = make_case(tmp_path / "r", rig, [(name, "imu1")], seed, **options)["effects"][0]["parameters"]
    nominal = nominal_fit(read(tmp_path / "r")[0])
    h = Hypothesis(EFFECTS[name], "imu1")
    told = {p: np.ravel(truth[p.name]) for p in h.effect.parameters}
    true = {h.key(p.name): np.log(x) if p.log else x for p, x in told.items()}
    begun = extended(nominal, (h,), true | {h.key("frequency"): true[h.key("frequency")] - 0.1})
    state = driven_by_motion(begun.model, begun.state, [h])
    return with_noise(solve(begun.model, state, calm_for_laws(begun, [h]), nominal.anchor, steps=4), 8), true


def off(fit, true):
    """Return by how many standard deviations the numbers of springs are off."""
    std = parameter_std(fit)
    return np.concatenate([(fit.state.values[name] - value) / std[name] for name, value in true.items()])


@pytest.mark.slow
def test_springs_on_fewer_knots_have_the_noise_that_was_put_in_and_their_numbers(tmp_path):
    fit, true = sprung(tmp_path, "soft_mount", 911, seconds=12.0)
    few = debiased(fit)
    assert few.model.tracks.knots.count < 0.4 * fit.model.tracks.knots.count
    told = declared(fit.model)
    level = {name: few.noise[name] / std for name, std in told.items()}
    assert all(abs(x - 1) < 0.03 for x in level.values())
    assert max(abs(fit.noise[name] / std - 1) for name, std in told.items()) > 0.035  # with a knot for every sample
    assert np.sqrt(np.mean(off(few, true) ** 2)) < np.sqrt(np.mean(off(fit, true) ** 2))
    assert np.max(np.abs(off(few, true))) < 3


@pytest.mark.long
def test_numbers_of_a_law_stay_while_its_motion_goes_to_fewer_knots(tmp_path):
    fit, true = sprung(tmp_path, "soft_mount", 912, seconds=6.0)
    few = coarser(fit, 2)
    for _, name, _ in law_parameters(fit):
        assert few.state.values[name] == pytest.approx(fit.state.values[name], abs=1e-4)
    assert not few.model.fixed  # and are free again
    assert true.keys() == {name for _, name, _ in law_parameters(few)}


@pytest.mark.slow
def test_a_lever_arm_is_pulled_off_what_noise_makes_of_it(tmp_path):
    """All three parts of the lever arm and of the centre of mass are pulled, beside stiffness and damping."""
    fit, true = sprung(tmp_path, "rocking_mount", 31, seconds=15.0, band=2.0, strength="weak")
    pulled = settled(fit)
    assert {name.split(".")[-1] for name in pulled.model.tilts} == {"frequency", "damping_ratio", "com", "lever"}
    assert {name.split(".")[-1] for name in fit.model.tilts} == {"frequency", "damping_ratio"}
    few = debiased(fit)
    before, after = (np.sqrt(np.mean(off(f, true) ** 2)) for f in (fit, few))
    assert after < 1.4 < before  # 1.1 and 1.7: 11 and 9 of 12 within 1.96


def test_what_has_no_law_stays_as_it_is(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 5, seconds=4.0, band=1.5)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert debiased(fit) is fit
    assert debiased(replace(fit, loose=2.0)).loose == 2.0


def left_of_the_law(per: float) -> float:
    """Return what a quintic spline with so many knots a period leaves of a ringing spring's law, over what shakes it.

    The spring of 14 Hz, damped by 0.14, is shaken at up to 20 Hz. Its movement is exact (its response in frequency, on
    a circle of 15 s), the spline the nearest one, the law's stiffness and damping what they are to leave least.
    """
    ratio, w, count, seconds = 0.14, 2 * np.pi * 14.0, 1 << 14, 15.0
    rng = np.random.default_rng(0)
    bins = 2 * np.pi * np.fft.rfftfreq(count, seconds / count)
    shaken = (rng.standard_normal(bins.size) + 1j * rng.standard_normal(bins.size)) * (bins < 2 * np.pi * 20)
    shaken[0] = 0.0
    time = np.arange(count) * seconds / count
    force = np.fft.irfft(shaken, count)
    moved = np.fft.irfft(shaken / (w**2 - bins**2 + 2j * ratio * w * bins), count)
    step = 2 * np.pi / (per * w)
    knots = np.arange(-5, int(seconds / step) + 6) * step
    inside = time < knots[-6]
    spline = make_lsq_spline(time[inside], moved[inside], knots[: np.searchsorted(knots, time[inside][-1]) + 6], 5)
    rows = time[(time > 1.0) & (time < seconds - 1.5)]
    pushed = np.interp(rows, time, force) - spline(rows, 2)
    columns = np.stack([spline(rows, 1), spline(rows)], axis=1)
    left = pushed - columns @ np.linalg.lstsq(columns, pushed, rcond=None)[0]
    return float(np.std(left) / np.std(force))


def test_a_spline_with_three_knots_a_period_is_no_solution_of_a_ringing_springs_law():
    assert left_of_the_law(3.0) > 0.15
    assert left_of_the_law(KNOT_SELECTION.knots_per_period) < 0.01


@pytest.mark.slow
def test_springs_that_ring_have_knots_enough_and_their_numbers(tmp_path):
    options = {"rig": "pendulum", "swing": True, "rate": 50.0, "band": 7.5, "vigour": 0.63}
    fit, true = sprung(tmp_path, "rocking_mount", 1, seconds=10.0, **options)
    many = finer(fit)
    assert 1 / (ringing(fit) * fit.model.tracks.knots.step) < 3.5
    assert 1 / (ringing(fit) * many.model.tracks.knots.step) == pytest.approx(KNOT_SELECTION.knots_per_period, rel=0.02)
    before, after = (np.sqrt(np.mean(off(settled(f), true) ** 2)) for f in (fit, many))
    assert after < 1.2 < 3 < before  # 0.6 and 3.7: 12 and 6 of 12 within 1.96
    assert finer(many) is many


@pytest.mark.slow
def test_springs_quicker_than_the_motion_follow_it_and_need_no_knots(tmp_path):
    fit, _ = sprung(tmp_path, "rocking_mount", 31, seconds=8.0, band=2.0, strength="weak")
    assert ringing(fit) == 0.0
    assert finer(fit) is fit


def test_a_motion_without_springs_keeps_its_knots_and_goes_to_more_the_same(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 5, seconds=5.0, rate=50.0, band=1.5)
    fit = nominal_fit(read(tmp_path / "r")[0])
    assert finer(fit) is fit
    many = coarser(fit, 0.6)
    assert many.model.tracks.knots.count > 1.6 * fit.model.tracks.knots.count
    time = np.linspace(0.3, 4.7, 300)
    columns = fit.model.tracks.columns("hinge")
    values = [matrix(f.model.tracks.knots, time) @ f.state.coefficients[:, columns] for f in (fit, many)]
    assert np.ptp(values[0]) > 0.3
    assert np.std(values[0] - values[1]) < 2e-3


def test_play_with_a_law_is_no_spring_that_rings(tmp_path):
    make_case(tmp_path / "r", "hinge", [], 5, seconds=4.0, band=4.0, base="fixed", encoder=True)
    fit = nominal_fit(read(tmp_path / "r")[0])
    with_play = extended(fit, (Hypothesis(EFFECTS["backlash"], "joint"),))
    assert with_play.model.hypotheses[0].effect.lawful
    assert ringing(with_play) == 0.0
    assert finer(with_play) is with_play

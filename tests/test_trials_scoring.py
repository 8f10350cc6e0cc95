"""What hand-made diagnoses are worth: right, wrong place, equivalent, missed, false alarm, double, outside."""

import numpy as np
import pytest
from scipy.stats import chi2, norm

from imubench.diagnosis.result import Diagnosis, Finding, FitQuality, Interval, Parameter, Rejected, Where
from imubench.trials import drawings
from imubench.trials.counted import FIGURES
from imubench.trials.detection import by_strength, power, wilson
from imubench.trials.figures import figures, judged, reliability
from imubench.trials.match import deviation, paired
from imubench.trials.scoring import failed, missed, score

BIAS = {"bias": [0.0, 0.1, 0.0]}


def effect(name, at, parameters=None, inside=True):
    return {"effect": name, "at": at, "parameters": parameters or {}, "inside": inside, "detail": {}}


def truth(*effects, kind="one", twins=None, visibility=12.0, bounds=None, **options):
    usual = {"colour": 0.0, "misdeclared": 0.0, "declare_noise": True, "rate": 100.0, "rate2": None}
    return {
        "kind": kind,
        "rig": "hinge",
        "observable": True,
        "effects": list(effects),
        "answers": [[e, *(twins or [])] for e in effects],
        "visibility": [visibility for _ in effects],
        "freedom": [3 for _ in effects],
        "bounds": [bounds for _ in effects],
        "options": usual | options,
    }


def found(name, at, confidence=0.95, parameters=None, equivalent=()):
    gain = Interval(100.0, (90.0, 110.0))
    same = tuple(Rejected(n, a, 99.0) for n, a in equivalent)
    where = Where(at, {}, (), (), "", 1.0) if name == "unknown" else None
    return Finding(name, at, confidence, parameters or {}, gain, same, "", where)


def said(*findings, verdict=None, heldout=(5.0, 1.2), misfit=(5.0, 1.2)):
    named = [f.named for f in findings if f.confidence >= 0.5]
    verdict = verdict or ("no mismatch" if not named else "unexplained" if not any(named) else "explained")
    verdict = "partly explained" if any(named) and not all(named) else verdict
    return Diagnosis("recording", "hinge", verdict, misfit, (), findings, (), FitQuality(heldout), "", 1.0)


def scored(truth_, diagnosis, name="000"):
    return score(name, truth_, diagnosis, 10.0, 1.5)


def test_a_right_name_at_its_place_counts_everywhere():
    value = Parameter(np.array([0.0, 0.11, 0.0]), np.full(3, 0.01), "m/s^2")
    s = scored(
        truth(effect("accel_bias", "imu2", BIAS), bounds={"bias": [0.005] * 3}),
        said(found("accel_bias", "imu2", parameters={"bias": value})),
    )
    assert (s.alarm, s.first_right, s.in_set, s.set_size, s.wrong) == (True, True, True, 1, ())
    assert s.beliefs == ((0.95, True),)
    assert s.errors[0].over_std == (0.0, 1.0, 0.0) and s.errors[0].over_bound == (0.0, 2.0, 0.0)
    assert s.removed == pytest.approx(3.8 / 4)  # of 4 above the noise 0.2 are left
    assert FIGURES["error_over_bound"]([s])[0] == pytest.approx(np.sqrt(4 / 3))  # RMS of 0, 2, 0


def test_the_wrong_place_is_wrong_however_right_the_name():
    s = scored(truth(effect("accel_bias", "imu2", BIAS)), said(found("accel_bias", "imu1")))
    assert (s.alarm, s.first_right, s.in_set, s.wrong) == (True, False, False, ("accel_bias at imu1",))
    assert s.beliefs == ((0.95, False),)
    assert s.errors == ()


def test_what_the_interface_calls_equivalent_is_right_with_its_own_parameters():
    lone = effect("moving_centre", "joint", {"slide": [0.01, 0.0, 0.0]})
    twin = effect("skin_sliding", "imu1", {"slide": [-0.01, 0.0, 0.0], "twist": [0.0, 0.0, 0.0]})
    slide = Parameter(np.array([-0.01, 0.001, 0.0]), np.full(3, 1e-3), "m/rad")
    s = scored(truth(lone, twins=[twin]), said(found("skin_sliding", "imu1", parameters={"slide": slide})))
    assert s.first_right and s.in_set
    assert s.errors[0].over_std == (0.0, 1.0, 0.0)  # beside the twin's sign, not the truth's


def test_a_truth_among_the_equivalents_is_in_the_set_but_not_first():
    s = scored(
        truth(effect("low_pass", "imu2", {"cutoff": 20.0})),
        said(found("time_offset", "imu2", equivalent=[("low_pass", "imu2")])),
    )
    assert (s.first_right, s.in_set, s.set_size, s.wrong) == (False, True, 2, ())
    assert s.beliefs == ((0.95, True),)  # the confidence is that of the set


def test_a_miss_is_no_alarm_and_fails_where_the_data_could_show_it():
    strong, weak = (scored(truth(effect("accel_bias", "imu2"), visibility=v), said()) for v in (12.0, 2.0))
    assert not strong.alarm and strong.first_right is None and strong.in_set is None
    assert missed(strong) and not missed(weak)
    assert FIGURES["detected_strong"]([strong, weak]) == (0.0, 1, 0)


def test_a_doubtful_finding_raises_no_alarm_but_counts_for_the_calibration():
    s = scored(truth(kind="none"), said(found("accel_bias", "imu2", 0.3)))
    assert not s.alarm and s.found == () and s.beliefs == ((0.3, False),)


@pytest.mark.parametrize("name", ["accel_bias", "unknown"])
def test_anything_said_of_nothing_is_a_false_alarm_of_its_kind_of_noise(name):
    white = scored(truth(kind="none"), said(found(name, "imu2")))
    coloured = scored(truth(kind="none", colour=0.1, misdeclared=0.1), said())
    off = scored(truth(kind="none", misdeclared=-0.1), said())
    undeclared = scored(truth(kind="none", misdeclared=-0.1, declare_noise=False), said())
    assert [s.noise for s in (white, coloured, off, undeclared)] == ["white", "coloured", "misdeclared", "white"]
    assert white.alarm and white.beliefs == ((0.95, False),)
    assert bool(white.wrong) == (name != "unknown")
    several = [white, coloured, off, undeclared]
    assert FIGURES["false_alarms_white"](several) == (0.5, 2, 1)
    assert FIGURES["false_alarms_coloured"](several) == (0.0, 1, 0)


def test_two_are_exact_only_without_a_third():
    both = truth(effect("accel_bias", "imu2"), effect("gyro_scale", "imu1"), kind="several")
    right = found("gyro_scale", "imu1"), found("accel_bias", "imu2")
    assert scored(both, said(*right)).exact
    assert not scored(both, said(right[0])).exact
    assert not scored(both, said(*right, found("gravity", "world"))).exact
    assert not scored(both, said(right[0], found("unknown", "imu2"))).exact
    s = scored(both, said(right[0], found("unknown", "imu2")))
    assert s.beliefs == ((0.95, True), (0.95, True))  # something unnamed is there indeed
    assert s.first_right is None  # asked of lone effects


def test_one_finding_is_no_answer_to_two_effects():
    both = truth(effect("low_pass", "imu2"), effect("time_offset", "imu2"), kind="several")
    wide = found("low_pass", "imu2", equivalent=[("time_offset", "imu2")])
    assert list(paired(both, [wide])) == [0]
    assert len(paired(both, [wide, found("low_pass", "imu2")])) == 2  # the wide one gives way to the narrow


def test_a_name_that_no_method_tells_from_physics_outside_the_table_is_right():
    outside = truth(effect("cross_talk", "imu1", inside=False), kind="outside")
    near = {"nearest": "gyro_misalignment at imu1", "beyond": 1.1, "least": 0.9, "same": ["gyro_misalignment at imu1"]}
    said_so = said(found("gyro_misalignment", "imu1"))
    for neighbour, wrong in ((near, ()), (near | {"same": []}, ("gyro_misalignment at imu1",)), (None, None)):
        s = scored(outside | {"neighbour": neighbour}, said_so)
        assert s.wrong == (("gyro_misalignment at imu1",) if wrong is None else wrong)
        assert s.flagged is False  # it counts as not flagged all the same
        assert (s.beyond, s.least) == ((1.1, 0.9) if neighbour else (None, None))
    elsewhere = scored(outside | {"neighbour": near}, said(found("gyro_misalignment", "imu2")))
    assert elsewhere.wrong == ("gyro_misalignment at imu2",)


@pytest.mark.parametrize(("beyond", "n"), [(4.0, 0), (12.0, 1), (None, 0)])
def test_only_what_is_far_from_every_name_must_be_flagged(beyond, n):
    outside = truth(effect("hysteresis", "imu1", inside=False), kind="outside")
    near = {"nearest": "low_pass at imu1", "beyond": beyond, "least": beyond, "same": []}
    neighbour = None if beyond is None else near
    s = scored(outside | {"neighbour": neighbour}, said(found("unknown", "imu1")))
    assert FIGURES["strange_flagged"]([s])[1:] == FIGURES["strange_located"]([s])[1:] == (n, n)
    assert FIGURES["outside_flagged"]([s])[1:] == (1, 1)


def test_what_a_search_could_flag_is_what_its_test_sees_at_a_distance():
    """Of one number: a normal beyond 3.76, which 0.01 / 60 has on both sides; of what has no distance, all."""
    outside = truth(effect("cubic", "imu1", inside=False), kind="outside") | {"freedom": [1]}
    near = {"nearest": "accel_scale at imu1", "beyond": 5.0, "least": 3.0, "same": []}
    known, least = (float(norm.cdf(x - norm.isf(0.01 / 120))) for x in (5.0, 3.0))
    for neighbours, shares in (
        ([near], (known, least)),
        ([None], (1, 1)),
        ([near, None], ((1 + known) / 2, (1 + least) / 2)),
    ):
        scores = [scored(outside | {"neighbour": n}, said()) for n in neighbours]
        for name, share in zip(("outside_possible", "outside_possible_least"), shares, strict=True):
            value, n, hits = FIGURES[name](scores)
            assert value == pytest.approx(share, abs=2e-4) and (n, hits) == (len(neighbours), None)
    assert FIGURES["outside_possible"]([scored(truth(effect("gravity", "world")), said())]) == (None, 0, None)


def test_physics_outside_the_table_is_right_as_unknown_at_its_place():
    outside = truth(effect("bias_jump", "imu2", inside=False), kind="outside")
    at_place, elsewhere = (scored(outside, said(found("unknown", at))) for at in ("imu2", "imu1"))
    assert (at_place.flagged, at_place.located) == (True, True)
    assert (elsewhere.flagged, elsewhere.located) == (True, False)
    named = scored(outside, said(found("accel_drift", "imu2")))
    assert (named.flagged, named.located, named.wrong) == (False, False, ("accel_drift at imu2",))


def test_a_diagnosis_that_breaks_off_finds_nothing():
    s = failed("000", truth(effect("bias_jump", "imu2", inside=False), kind="outside"), 3.0, "stopped after 3 s")
    assert (s.alarm, s.flagged, s.located) == (False, False, False)
    assert FIGURES["answered"]([s]) == (0.0, 1, 0)
    assert next(f for f in figures([s]) if f.name == "answered").passed


def test_parameters_are_compared_by_the_conventions_of_the_table():
    def told(*value):
        return Parameter(np.array(value), np.ones(len(value)), "")

    hum = deviation("vibration", "frequency", told(30.0), np.array(70.0), 100.0)
    assert hum == pytest.approx(0.0)  # 70 Hz sampled at 100 Hz is an image of 30 Hz
    sign = deviation("vibration", "amplitude", told(-1.0, 2.0, 0.0), np.array([1.0, -2.0, 0.1]), 100.0)
    assert sign == pytest.approx([0.0, 0.0, 0.1])
    turned = deviation("joint_play", "direction", told(3.0), np.array(3.0 - np.pi), 100.0)
    assert turned == pytest.approx(0.0)
    one = deviation("soft_mount", "frequency", told(11.0), np.array([10.0, 11.0, 12.0]), 100.0)
    assert one == pytest.approx([0.0])  # of three axes: their mean
    assert deviation("accel_bias", "bias", told(1.0, 2.0), np.zeros(3), 100.0) is None


@pytest.mark.parametrize(("rig", "off"), [("pendulum", 0.5), ("hinge", -59.5)])
def test_the_angle_of_a_pendulums_stop_has_no_sign(rig, off):
    """It is about a level axis whose heading is free; a hinge's axis is declared."""
    angle = Parameter(np.array(-0.295), np.array(0.01), "rad")
    true = truth(effect("end_stop", "joint", {"angle": 0.3})) | {"rig": rig}
    (error,) = scored(true, said(found("end_stop", "joint", parameters={"angle": angle}))).errors
    assert error.over_std == pytest.approx((off,))


@pytest.mark.parametrize(
    ("rig", "twist", "off"),
    [("pendulum", -0.1, (0.0, 0.0)), ("pendulum", 0.01, (-4.0, -9.0)), ("hinge", -0.1, (-4.0, -20.0))],
)
def test_what_slides_with_a_pendulums_swing_has_no_sign_but_one_for_all_of_it(rig, twist, off):
    """Half a turn of heading turns the swing's sign, and with it those of slide and twist together."""
    true = truth(effect("skin_sliding", "imu1", {"slide": [0.02, 0.0, 0.0], "twist": [0.0, 0.1, 0.0]})) | {"rig": rig}
    slide = Parameter(np.array([-0.02, 0.0, 0.0]), np.full(3, 0.01), "m/rad")
    turn = Parameter(np.array([0.0, twist, 0.0]), np.full(3, 0.01), "rad/rad")
    errors = scored(true, said(found("skin_sliding", "imu1", parameters={"slide": slide, "twist": turn}))).errors
    assert [errors[0].over_std[0], errors[1].over_std[1]] == pytest.approx(off)


def test_wilson_intervals_are_those_of_the_textbook():
    assert wilson(0, 10) == pytest.approx((0.0, 0.2775), abs=1e-4)  # z^2 / (n + z^2)
    assert wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)  # Newcombe 1998's formula by hand
    assert wilson(0, 0) == (0.0, 1.0)


def test_theoretical_power_is_what_simulation_gives():
    rng, strength, freedom = np.random.default_rng(0), 3.0, 4
    draws = rng.standard_normal((40_000, freedom))
    draws[:, 0] += strength
    share = np.mean((draws**2).sum(axis=1) > chi2.isf(0.01, freedom))
    assert power(strength, freedom) == pytest.approx(share, abs=0.008)  # three standard errors of 40000 draws
    assert power(0.0, freedom) == pytest.approx(0.01, abs=1e-6)


def test_detection_is_counted_by_strength_beside_its_theory():
    seen = [scored(truth(effect("accel_bias", "imu2"), visibility=5.0), said(found("accel_bias", "imu2")))] * 3
    blind = [scored(truth(effect("accel_bias", "imu2"), visibility=5.0), said())]
    unknown = [scored(truth(effect("dropouts", "imu2"), visibility=None), said())]
    (row,) = by_strength(seen + blind + unknown)
    assert (row.low, row.n, row.hits) == (4.0, 4, 3)
    assert row.theory == pytest.approx(power(5.0, 3))


def test_stated_confidence_is_held_against_what_was_true():
    right = scored(truth(effect("accel_bias", "imu2")), said(found("accel_bias", "imu2", 0.95)))
    wrong = scored(truth(effect("accel_bias", "imu2")), said(found("accel_scale", "imu2", 0.92)))
    (row,) = reliability([right, wrong])
    assert (row["n"], row["true"]) == (2, 1) and row["stated"] == pytest.approx(0.935)


@pytest.mark.parametrize("n", range(1, 12))
def test_every_share_can_be_drawn(n):
    right = scored(truth(effect("accel_bias", "imu2")), said(found("accel_bias", "imu2", 0.95)))
    scores = [right] * n  # rounding puts the end of some of these intervals below the share of 1
    drawings.reliability(reliability(scores)), drawings.detection(by_strength(scores), scores)


def test_an_aim_missed_by_few_cases_is_open_and_by_many_failed():
    limit = {"name": "x", "title": "x", "aim": [0.9, 1.0], "guard": [0.5, 1.0]}
    assert judged(limit, 0.95, 20, 19).verdict == "holds"
    assert judged(limit, 0.75, 4, 3).verdict == "open"
    assert judged(limit, 0.75, 400, 300).verdict == "fails"
    assert not judged(limit, 0.75, 400, 300).passed and judged(limit, 0.25, 4, 1).passed
    assert judged({**limit, "aim": [0.92, 0.97]}, 0.9, 10, 9).verdict == "open"  # the interval has the aim inside
    assert judged(limit, None, 0, 0).verdict == "none"


def test_worse_naming_or_silence_passes_a_guard():
    bias = truth(effect("accel_bias", "imu2", BIAS))
    right, wrong = scored(bias, said(found("accel_bias", "imu2"))), scored(bias, said(found("accel_bias", "imu1")))
    silent, loud = (scored(truth(kind="none"), said(*f)) for f in ((), (found("gyro_bias", "imu1", 0.7),)))

    def passed(*cases):
        return {f.name for f in figures(cases) if f.passed}

    assert passed(right, silent) == set()
    assert passed(right, wrong, wrong, silent) == {"first_right", "confidently_wrong"}
    assert passed(right, silent, loud) == {"silent"}

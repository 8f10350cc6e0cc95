"""Recordings that make no sense are said to make none, in words and at once; those with any real effect are not."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.convert import CONVERTERS
from imubench.diagnosis import on_disk
from imubench.diagnosis.budget import Budget
from imubench.diagnosis.nonsense import nonsense
from imubench.diagnosis.nonsense.different_motions import different_motions
from imubench.diagnosis.nonsense.handedness import SIGNED_PERMUTATIONS, handedness
from imubench.diagnosis.nonsense.mirrored import faults, mirrored
from imubench.diagnosis.nonsense.permuted import permuted
from imubench.diagnosis.nonsense.shared_motion import held_out, shared, squares
from imubench.diagnosis.nonsense.stretch import averaged, cut, grid, gridded
from imubench.diagnosis.nonsense.stuck import stuck
from imubench.diagnosis.nonsense.swapped import reading, swapped
from imubench.diagnosis.nonsense.too_few_samples import too_few_samples
from imubench.diagnosis.pipeline import diagnose
from imubench.diagnosis.report.headline import headline
from imubench.diagnosis.result import Finding, Interval, Parameter
from imubench.diagnosis.result_file import as_dict
from imubench.diagnosis.result_read import read_diagnosis
from imubench.format1 import read, write_recording
from imubench.proof.case import make_case
from imubench.recording import Imu, Recording
from imubench.reproduce.report import escape
from imubench.rotations import conjugate, from_matrix, log, multiply

I = np.eye(3)  # noqa: E741  # the identity, as in the equations
RIGS = {
    "hinge": {"rig": "hinge"},
    "fixed": {"rig": "hinge", "base": "fixed"},
    "swing": {"rig": "hinge", "base": "fixed", "swing": True},
    "pendulum": {"rig": "pendulum"},
    "free": {"rig": "free"},
    "encoder": {"rig": "hinge", "encoder": True},
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Return a function that makes a recording of 16 s at 50 Hz by the generator of the proof, once."""
    folder, known = tmp_path_factory.mktemp("made"), {}

    def make(rig: str, seed: int, effects=(), strength: str = "strong") -> Recording:
        key = (rig, seed, str(effects))
        if key not in known:
            target = folder / str(len(known))
            make_case(target, effects=effects, seed=seed, strength=strength, seconds=16.0, rate=50.0, **RIGS[rig])
            known[key] = read(target)[0]
        return known[key]

    return make


def changed(recording: Recording, at: str, gyro=I, accel=I) -> Recording:
    """The recording with an IMU that reports matrices times what it should."""
    return replace(
        recording,
        imus=tuple(
            replace(i, gyro=i.gyro @ gyro.T, accel=i.accel @ accel.T) if i.name == at else i for i in recording.imus
        ),
    )


def flip(*axes: int) -> np.ndarray:
    return np.diag([-1.0 if k in axes else 1.0 for k in range(3)])


def said(found) -> list[str]:
    return [n.what for n in found]


def of_two(one: Recording, other: Recording) -> Recording:
    """The first recording with the second IMU of another one."""
    later = other.imus[1]
    return replace(
        one, imus=(one.imus[0], replace(later, time=later.time - later.time[0] + one.imus[0].time[0])), encoders=()
    )


# What makes sense


@pytest.mark.parametrize("rig", RIGS)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_clean_recording_of_any_rig_makes_sense(made, rig, seed):
    assert nonsense(made(rig, seed)) == ()


@pytest.mark.parametrize(
    ("rig", "effect"),
    [
        ("hinge", ("time_offset", "imu2")),
        ("hinge", ("low_pass", "imu1")),
        ("hinge", ("joint_play", "joint")),
        ("hinge", ("soft_mount", "imu2")),
        ("hinge", ("rocking_mount", "imu1")),
        ("hinge", ("mount_pose", "imu2")),
        ("hinge", ("saturation", "imu1")),
        ("hinge", ("quantisation", "imu2")),
        ("hinge", ("gyro_bias", "imu1")),
        ("hinge", ("skin_sliding", "imu2")),
        ("fixed", ("gyro_bias", "imu2")),
        ("swing", ("gyro_bias", "imu2")),
        ("swing", ("accel_misalignment", "imu2")),
        ("encoder", ("backlash", "joint")),
        ("pendulum", ("moving_pivot", "joint")),
        ("pendulum", ("g_sensitivity", "imu1")),
        ("free", ("time_offset", "imu1")),
    ],
)
def test_a_strong_effect_is_no_nonsense(made, rig, effect):
    assert nonsense(made(rig, 3, [effect])) == ()


@pytest.mark.long
def test_real_recordings_make_sense(recordings):
    """The six hinges of `diodem`, screwed on and on foam, and the six trials of `broad`, 30 s of each."""
    found = {}
    for kind in ("rigid", "nonrigid"):
        for joint in ("2-3", "3-4", "4-5"):
            (out,) = CONVERTERS["diodem"](recordings / "diodem" / "trial1", segments=joint, imu=kind)
            found[kind, joint] = nonsense(cut(out.recording, 20.0, 50.0))
    for path in sorted((recordings / "broad").glob("*.hdf5")):
        (out,) = CONVERTERS["broad"](path)
        found[path.name] = nonsense(cut(out.recording, 60.0, 90.0))
    assert len(found) == 12
    assert {name: said(n) for name, n in found.items() if n} == {}


# Mirrored sensors


def test_there_are_48_ways_and_the_first_changes_nothing():
    assert len(SIGNED_PERMUTATIONS) == 48
    assert np.array_equal(SIGNED_PERMUTATIONS[0], I)
    assert len({tuple(m.ravel()) for m in SIGNED_PERMUTATIONS}) == 48
    assert sum(np.linalg.det(m) > 0 for m in SIGNED_PERMUTATIONS) == 24


@pytest.mark.parametrize("way", range(0, 48, 5))
def test_the_way_that_a_gyroscope_is_turned_is_the_one_found(made, way):
    """The gyroscope reads the transpose of what the accelerometer's axes would have it read."""
    imu = made("pendulum", 1).imus[0]
    samples = gridded(imu, grid([imu.time]))
    found = handedness(replace(samples, gyro=samples.gyro @ SIGNED_PERMUTATIONS[way]))
    assert found.best == way
    assert found.wrong == (way != 0)


def test_every_fault_belongs_to_the_way_that_it_makes():
    """f_r' = -S w_r x f_r follows from f' = -w x f for a random rate and force."""
    rng = np.random.default_rng(0)
    w, f = rng.standard_normal((2, 3))
    for fault in faults():
        ways = [m for m in SIGNED_PERMUTATIONS if fault.fits(m)]
        assert len(ways) == 1, fault.what
        w_r, f_r, slope = fault.gyro @ w, fault.accel @ f, fault.accel @ -np.cross(w, f)
        # rounding
        np.testing.assert_allclose(slope, -np.cross(ways[0] @ w_r, f_r), atol=1e-12)


def test_an_encoder_alone_makes_sense(swung):
    assert nonsense(swung({"dry_friction": 0.02}, 3.0)) == ()


@pytest.mark.long
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("rig", ["hinge", "pendulum", "free"])
def test_a_mirrored_sensor_is_named_with_its_axis(made, rig, axis):
    recording, at = made(rig, 1), made(rig, 1).imus[-1].name
    name, mirror = "xyz"[axis], flip(axis)
    both = f"{at} looks mirrored in {name}: gyr_{name} and acc_{name} have the wrong sign"
    assert said(mirrored(changed(recording, at, mirror, mirror))) == [both]
    gyro = f"{at}'s gyroscope looks mirrored in {name}: gyr_{name} has the wrong sign"
    assert said(mirrored(changed(recording, at, gyro=mirror))) == [gyro]
    accel = f"{at}'s accelerometer looks mirrored in {name}: acc_{name} has the wrong sign"
    assert said(mirrored(changed(recording, at, accel=mirror))) == [accel]


@pytest.mark.long
def test_axes_that_differ_between_gyroscope_and_accelerometer_are_said(made):
    turned = changed(made("hinge", 1), "imu2", gyro=I[[1, 2, 0]])
    (what,) = said(mirrored(turned))
    assert what == (
        "imu2's gyroscope and accelerometer have different axes: one reads (y, z, x) where the other has (x, y, z)"
    )
    swapped_axes = changed(made("hinge", 1), "imu2", I[[0, 2, 1]], I[[0, 2, 1]])
    assert said(mirrored(swapped_axes)) == ["imu2 looks mirrored: its y and z axes have changed places"]


@pytest.mark.long
def test_two_imus_mirrored_alike_are_both_named(made):
    mirror = flip(2)
    recording = changed(changed(made("hinge", 1), "imu1", mirror, mirror), "imu2", mirror, mirror)
    ends = "looks mirrored in z: gyr_z and acc_z have the wrong sign"
    assert said(mirrored(recording)) == [f"imu1 {ends}", f"imu2 {ends}"]


def test_where_no_mount_is_declared_the_mirrored_axis_is_left_open(made):
    mirror = flip(1)
    recording = changed(made("hinge", 1), "imu2", mirror, mirror)
    recording = replace(recording, imus=tuple(replace(i, mount_rotation_std=None) for i in recording.imus))
    assert said(mirrored(recording)) == [
        "imu2 looks mirrored: its axes are left-handed, or its gyroscope has the wrong sign"
    ]


def test_a_sensor_at_rest_is_not_called_mirrored(made):
    """Drift of less than the least velocity that counts, whatever its ratio."""
    time = np.arange(0, 20, 0.02)
    rng = np.random.default_rng(0)
    gyro = 0.002 * rng.standard_normal((1000, 3)) + 0.01
    accel = 0.02 * rng.standard_normal((1000, 3)) + [0.0, 0.0, 9.81]
    still = Imu("imu1", time, gyro, accel, 50.0)
    assert list(mirrored(Recording("still", "pendulum", (still,)))) == []


# Sensors of two recordings


@pytest.mark.parametrize("seeds", [(1, 2), (2, 4), (5, 6), (7, 8)])
def test_two_unrelated_imus_do_not_move_together(made, seeds):
    pair = of_two(*(made("hinge", seed) for seed in seeds))
    assert said(different_motions(pair)) == ["the two IMUs do not move together"]


def test_a_pose_or_an_encoder_of_another_recording_does_not_go_with_the_imus(made):
    one, other = made("free", 1), made("free", 2)
    assert said(different_motions(replace(one, poses=other.poses))) == [
        "imu1 and the measured pose do not move together"
    ]
    one, other = made("encoder", 1), made("encoder", 2)
    found = said(different_motions(replace(one, encoders=other.encoders)))
    assert found == ["the IMUs and the encoder do not move together"]


def test_clocks_apart_by_less_than_a_diagnosis_looks_for_are_no_nonsense(made):
    recording = made("hinge", 1)
    one, two = recording.imus
    for late, expected in ((0.2, []), (3.0, ["the two IMUs do not move together"])):
        assert said(different_motions(replace(recording, imus=(one, replace(two, time=two.time + late))))) == expected


def test_what_imus_share_does_not_depend_on_their_mounts_scales_and_biases(made):
    one, two = made("hinge", 1).imus
    edges = grid([one.time, two.time], 25.0)
    first, second = (averaged(i.time, i.gyro, edges) for i in (one, two))
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.standard_normal((3, 3)))[0] @ np.diag([1.1, 0.9, 1.0])
    plain, moved = (held_out(squares(first), squares(w)) for w in (second, second @ turn.T + [0.1, -0.2, 0.1]))
    # a linear map of the signals; what remains is the ridge of a thousandth
    assert moved == pytest.approx(plain, abs=0.01)
    assert plain > 0.95


def test_noise_shares_nothing_and_a_copy_everything():
    rng = np.random.default_rng(2)
    one, other = rng.standard_normal((2, 1000, 3))
    assert abs(held_out(one, other)) < 0.2  # 1 / sqrt(1000) is 0.03; the pair is chosen among three by three
    assert held_out(one, one @ rng.standard_normal((3, 3))) > 0.99
    assert shared(one, other, 0.04).unrelated
    assert not shared(one, one, 0.04).unrelated
    assert shared(one[:50], other[:50], 0.04) is None  # two seconds say nothing


def test_a_rig_that_hardly_turns_across_its_hinge_is_not_judged(made):
    """Both IMUs turn about the hinge's axis alone, each as it likes: nothing is shared, and nothing must be."""
    time = np.arange(0, 20, 0.02)
    rng = np.random.default_rng(3)
    imus = []
    for name in ("imu1", "imu2"):
        rate = np.zeros((1000, 3))
        rate[:, 1] = np.convolve(rng.standard_normal(1000), np.ones(20) / 4, "same")
        force = np.tile([0.0, 0.0, 9.81], (1000, 1)) + 0.02 * rng.standard_normal((1000, 3))
        imus.append(Imu(name, time, rate + 0.002 * rng.standard_normal((1000, 3)), force, 50.0))
    assert list(different_motions(Recording("planar", "hinge", tuple(imus)))) == []


# Swapped files


@pytest.mark.parametrize("rig", ["hinge", "fixed"])
@pytest.mark.parametrize("seed", [1, 3, 4])
def test_swapped_files_are_named(made, rig, seed):
    """Not of seed 2, whose second mount is the first one turned half round the hinge: either order goes with it."""
    recording = made(rig, seed)
    one, two = recording.imus
    odd = replace(recording, imus=(reading(one, two), reading(two, one)))
    assert said(nonsense(odd)) == ["imu1 and imu2 look swapped: their files go with each other's mounts"]


def test_labels_swapped_with_their_mounts_are_another_rig_and_no_nonsense(made):
    one, two = made("hinge", 1).imus
    other = replace(made("hinge", 1), imus=(replace(two, name="imu1"), replace(one, name="imu2")))
    assert list(swapped(other)) == []


# Axes in another order, which is a mount that the search finds


def posed(at: str, turn, declared: Imu) -> Finding:
    rotation = Parameter(np.asarray(turn), np.full(3, 0.01), "rad")
    return Finding("mount_pose", at, 0.96, {"rotation": rotation}, Interval(100.0, (90.0, 110.0)))


@pytest.mark.parametrize("rig", ["hinge", "free"])
def test_a_mount_turned_by_an_order_of_axes_is_said_to_look_permuted(made, rig):
    recording = made(rig, 1)
    imu = recording.imus[-1]
    turn = log(from_matrix(I[[1, 2, 0]].T))  # the sensor reads (y, z, x): R' of what it should
    (found,) = permuted([posed(imu.name, turn, imu)], recording)
    assert found.what == f"{imu.name}'s axes look permuted: it reads (y, z, x) where the model has (x, y, z)"
    assert permuted([posed(imu.name, 0.5 * turn, imu)], recording) == ()
    assert permuted([posed(imu.name, [0.3, 0.1, -0.2], imu)], recording) == ()
    assert multiply(conjugate(imu.mount_quaternion), imu.mount_quaternion)[0] == pytest.approx(1.0)  # a unit


# Stuck sensors


def with_imu(recording: Recording, at: str, **parts) -> Recording:
    return replace(recording, imus=tuple(replace(i, **parts) if i.name == at else i for i in recording.imus))


def held(values: np.ndarray, columns, start: int = 0) -> np.ndarray:
    out = values.copy()
    out[start:, columns] = out[start, columns]
    return out


def test_a_stuck_triple_axis_or_imu_is_called_stuck(made):
    recording = made("hinge", 1)
    imu = recording.imus[1]
    every = [0, 1, 2]
    cases = {
        "imu2's gyroscope is stuck: it reads the same in every sample": {"gyro": held(imu.gyro, every)},
        "imu2's accelerometer is stuck: it reads the same in every sample": {"accel": held(imu.accel, every)},
        "gyr_z of imu2 is stuck: it reads the same in every sample": {"gyro": held(imu.gyro, [2])},
        "acc_x and acc_y of imu2 are stuck: they read the same in every sample": {"accel": held(imu.accel, [0, 1])},
        "imu2 is stuck: it reads the same in every sample, while the rig moves": {
            "gyro": held(imu.gyro, every),
            "accel": held(imu.accel, every),
        },
        "imu2's gyroscope is stuck: it reads the same for 75 % of the recording": {
            "gyro": held(imu.gyro, every, len(imu.time) // 4)
        },
    }
    for what, parts in cases.items():
        assert said(stuck(with_imu(recording, "imu2", **parts))) == [what]


def test_what_is_clipped_rounded_at_rest_or_clamped_is_not_called_stuck(made):
    recording = made("hinge", 1)
    one, two = recording.imus
    clipped = np.clip(two.accel, -1.0, 1.0)  # every axis at the same limit for most of the time
    assert list(stuck(with_imu(recording, "imu2", accel=clipped))) == []
    clipped = np.where(np.abs(two.accel) > 0, 2.0, two.accel)
    assert list(stuck(with_imu(recording, "imu2", accel=clipped, accel_range=2.0))) == []
    still = {"gyro": np.zeros_like(two.gyro), "accel": np.tile([0.0, 0.0, 9.8], (len(two.time), 1))}
    assert list(stuck(with_imu(made("fixed", 1), "imu1", **{k: v[: one.time.size] for k, v in still.items()}))) == []
    noise = np.random.default_rng(0).standard_normal(two.accel.shape)
    rounded = {"gyro": np.zeros_like(two.gyro), "accel": still["accel"] + 0.02 * noise}  # at rest, its gyro coarse
    assert list(stuck(with_imu(recording, "imu2", **rounded))) == []


def test_readings_that_never_change_anywhere_say_nothing(made):
    """All-zero samples with gravity = 0 were a trace of a singular matrix."""
    recording = made("hinge", 1)
    zero = replace(
        recording,
        gravity=0.0,
        imus=tuple(replace(i, gyro=0 * i.gyro, accel=0 * i.accel) for i in recording.imus),
    )
    found, _ = diagnose(zero)
    assert found.verdict == "unobservable"
    assert "imu1 reads the same in every sample: it is stuck, or nothing moves" in headline(found)
    assert not found.findings


# Too few samples


def test_too_few_samples_are_said_with_their_number(made):
    recording = made("hinge", 1)
    one, two = recording.imus

    def only(keep) -> Recording:
        some = replace(one, time=one.time[keep], gyro=one.gyro[keep], accel=one.accel[keep])
        return replace(recording, imus=(some, two))

    assert said(too_few_samples(only([0, -1]))) == ["imu1 has too few samples: 2, where 32 are needed"]
    assert said(too_few_samples(only(slice(None, None, 16)))) == [
        "imu1 has too few samples: 50 in 15.7 s, where 50 Hz are declared"
    ]
    assert said(too_few_samples(only(slice(0, 40)))) == ["imu1 has samples of 0.8 s only, in a recording of 16.0 s"]
    assert said(too_few_samples(recording)) == []
    assert said(too_few_samples(only(slice(0, None, 4)))) == []  # 12 Hz where 50 are declared are samples still


# What comes out


@pytest.mark.parametrize("case", ["unrelated", pytest.param("mirrored", marks=pytest.mark.long), "swapped", "stuck"])
def test_a_diagnosis_of_nonsense_ends_before_any_fit_and_says_it(made, case):
    recording = made("hinge", 1)
    one, two = recording.imus
    odd = {
        "unrelated": of_two(recording, made("hinge", 2)),
        "mirrored": changed(recording, "imu2", flip(2), flip(2)),
        "swapped": replace(recording, imus=(reading(one, two), reading(two, one))),
        "stuck": with_imu(recording, "imu2", gyro=held(two.gyro, [0, 1, 2])),
    }[case]
    budget = Budget(0.0)  # with no time for any fit
    found, evidence = diagnose(odd, budget=budget)
    assert not budget.not_tried
    assert found.verdict == "unexplained"
    assert [f.effect for f in found.findings] == ["unknown"]  # and no saturation
    (wrong,) = found.nonsense
    assert found.findings[0].at == wrong.at
    assert wrong.what[3:] in headline(found)  # but for a capital letter
    assert not found.fitted
    assert evidence.traces


@pytest.mark.parametrize("case", ["two samples", "stuck"])
def test_every_file_of_a_diagnosis_of_nonsense_is_written(made, case, tmp_path):
    recording = made("hinge", 1)
    one, two = recording.imus
    ends = [0, -1]
    if case == "stuck":
        odd = with_imu(recording, "imu2", gyro=held(two.gyro, [0, 1, 2]))
    else:
        odd = replace(
            recording, imus=(replace(one, time=one.time[ends], gyro=one.gyro[ends], accel=one.accel[ends]), two)
        )
    write_recording(odd, tmp_path / "rec")
    done = on_disk.diagnose_on_disk(tmp_path / "rec", tmp_path / "out")
    assert {"diagnosis.json", "diagnosis.rrd", "model", "report.html"} <= {p.name for p in (tmp_path / "out").iterdir()}
    again = read_diagnosis(tmp_path / "out")
    assert as_dict(again) == as_dict(done.diagnosis)
    (wrong,) = again.nonsense
    assert escape(wrong.what) in (tmp_path / "out" / "report.html").read_text()
    assert again.verdict == ("unexplained" if case == "stuck" else "unobservable")
    assert wrong.missing == (case != "stuck")

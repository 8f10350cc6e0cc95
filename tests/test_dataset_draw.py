"""What a dataset draws: by (spec, seed, number) alone, within its ranges, every effect as its law says."""

import numpy as np
import pytest

from imubench.dataset.drawing import draw, split_of
from imubench.dataset.playing import make
from imubench.dataset.ranges import Range, parse_range
from imubench.dataset.spec import parse_spec
from imubench.effects import EFFECTS
from imubench.errors import InputError
from imubench.sim.injected import all_injectable, rolled_out
from imubench.sim.play import play

HINGE = "seconds = 4\n[[rig]]\nfamily = 'hinge'\n[[imu]]\nprofile = 'perfect'\n"
SWINGING = HINGE.replace("'hinge'", "'hinge'\nbase = 'fixed'") + "[[motion]]\nkind = 'swing'\n"
ALL = """
seconds = 10
recordings_per_rig = 3
[[rig]]
family = "hinge"
soft_probability = 0.5
[[rig]]
family = "hinge"
base = "fixed"
[[rig]]
family = "pendulum"
rocking_probability = 0.5
[[rig]]
family = "free"
mount_rotation = [-0.2, 0.2]
[[motion]]
kind = "random"
[[motion]]
kind = "olsson2020"
[[motion]]
kind = "pendulum"
"""
GIVEN = {  # parameters of effects without a prior
    "gyro_noise": "std = 0.05",
    "accel_noise": "std = 0.5",
    "saturation": "limit = 0.5\nchannels = ['gyro']",
    "quantisation": "step = 0.5\nchannels = ['accel']",
    "dropouts": "fraction = 0.2",
    "vibration": "frequency = 12\namplitude = { std = 0.5 }",
    "impacts": "count = 3",
    "low_pass": "cutoff = 5",
    "moving_pivot": "std = 0.3\nband = [0.5, 5]",
    "joint_play": "range = 0.03",
    "end_stop": "angle = [-0.4, 0.4]",
}


def spec_of(text: str):
    return parse_spec({"spec.toml": text.encode()})


def same(one, other) -> bool:
    pairs = zip(one.recording.imus, other.recording.imus, strict=True)
    alike = all(np.array_equal(getattr(a, k), getattr(b, k)) for a, b in pairs for k in ("time", "gyro", "accel"))
    return alike and np.array_equal(one.truth.sensors[0].specific_force, other.truth.sensors[0].specific_force)


def test_a_recording_follows_from_spec_seed_and_number_whatever_was_made_before():
    spec = spec_of(ALL)
    forth = {i: make(spec, 7, i) for i in (0, 4, 9)}
    back = {i: make(spec_of(ALL), 7, i) for i in (9, 4, 0)}
    assert all(same(forth[i], back[i]) for i in forth)
    assert not same(forth[0], make(spec, 8, 0))


def test_recordings_of_a_rig_share_its_geometry_and_its_split_and_nothing_else():
    spec = spec_of(ALL)
    first, second, third, other = (draw(spec, 3, i) for i in range(4))
    assert (first.rig_index, third.rig_index, other.rig_index) == (0, 0, 1)
    assert first.split == second.split == third.split
    assert np.array_equal(first.rig.segments[0].com, third.rig.segments[0].com)
    assert first.rig.family == third.rig.family
    assert not np.array_equal(first.declared["imu1"].position, second.declared["imu1"].position)
    assert not np.array_equal(first.rig.segments[0].com, other.rig.segments[0].com)


def test_splits_get_their_fractions_of_any_rigs_in_a_row():
    spec = spec_of(HINGE)
    for seed in range(3):
        splits = [split_of(spec, seed, r) for r in range(100)]
        for name, fraction in spec.splits.items():
            # Steps of the golden ratio miss a fraction of 100 by less than 4 (their discrepancy is about log n).
            assert abs(splits.count(name) - 100 * fraction) < 4


def test_every_family_and_kind_of_motion_comes_and_stays_in_its_ranges():
    spec = spec_of(ALL)
    drawn = [draw(spec, 0, 3 * r) for r in range(120)]
    assert {d.rig.family for d in drawn} == {"hinge", "pendulum", "free"}
    assert {d.rig.base for d in drawn} == {"free", "fixed"}
    kinds = {d.motion_name.split("-")[0] for d in drawn}
    assert kinds == {"random", "olsson2020", "pendulum"}
    for d in drawn:
        assert d.motion_name == "random" or d.rig.family == ("pendulum" if d.motion_name == "pendulum" else "hinge")
        assert not d.motion_name.startswith("olsson") or d.rig.base == "free"
        for segment in d.rig.segments:
            assert 0.1 <= segment.mass <= 2.0
        for mount in d.rig.mounts:
            assert np.linalg.norm(mount.position) < 0.26  # 0.25 m along, 0.04 m off on each side
    assert {e["effect"] for d in drawn for e in d.effects} == {"soft_mount", "rocking_mount"}


def test_without_effects_and_with_perfect_sensors_a_recording_is_the_simulators_own():
    spec = spec_of(HINGE)
    made = make(spec, 0, 0)
    played = play(made.drawn.rig, draw(spec, 0, 0).motion, 4.0, 100.0)
    for imu, sensor in zip(made.recording.imus, played.sensors, strict=True):
        assert np.array_equal(imu.gyro, sensor.gyro)
        assert np.array_equal(imu.accel, sensor.specific_force)
    assert np.array_equal(made.truth.joint_angle, played.joint_angle)


@pytest.mark.parametrize("name", all_injectable())
def test_every_effect_shows_in_the_samples_and_in_the_table(name):
    rig = (
        HINGE.replace("hinge", "pendulum")
        if name == "moving_pivot"
        else SWINGING
        if rolled_out(name)
        else HINGE + "[encoder]\n"
        if name == "backlash"
        else HINGE
    )
    spec = spec_of(rig + f"[[effect]]\nname = '{name}'\n{GIVEN.get(name, '')}\n")
    plain, made = make(spec_of(rig), 0, 0), make(spec, 0, 0)
    assert made.drawn.effects, name
    assert {e["effect"] for e in made.drawn.effects} == {name}
    effect = EFFECTS[name]
    known = {p.name for p in effect.parameters if p.reported} | {f.name for f in effect.found} | set(effect.settings)
    for e in made.drawn.effects:
        assert set(e["parameters"]) == known
        assert e["at"] in ("imu1", "imu2", "joint", "body", "world")
        if name == "inertia":  # what is believed is changed, and not the world
            assert made.recording.body.inertia[1] != plain.recording.body.inertia[1]
            continue
        if name == "backlash":
            (with_it,), (without,) = made.recording.encoders, plain.recording.encoders
            assert 0 < np.abs(with_it.angle - without.angle).max() <= e["parameters"]["range"] + 1e-12
            continue
        at = e["at"] if e["at"].startswith("imu") else made.recording.imus[-1].name
        with_it, without = made.recording.imu(at), plain.recording.imu(at)
        changed = with_it.time.size != without.time.size or any(
            not np.array_equal(getattr(with_it, key), getattr(without, key)) for key in ("time", "gyro", "accel")
        )
        assert changed


def test_the_law_of_a_bias_and_of_a_shifted_mount_is_the_contracts():
    bias = HINGE + "[[effect]]\nname = 'gyro_bias'\nat = 'imu2'\nbias = [0.1, 0.2]\n"
    plain, made = make(spec_of(HINGE), 0, 0), make(spec_of(bias), 0, 0)
    (effect,) = made.drawn.effects
    offset = made.recording.imu("imu2").gyro - plain.recording.imu("imu2").gyro
    assert np.allclose(offset, effect["parameters"]["bias"], atol=1e-12)  # sums of numbers near 1, rounded
    assert np.array_equal(made.recording.imu("imu1").gyro, plain.recording.imu("imu1").gyro)
    moved = make(spec_of(HINGE + "[[effect]]\nname = 'mount_pose'\nat = 'imu1'\n"), 0, 0)
    (effect,) = moved.drawn.effects
    declared = moved.recording.imu("imu1").mount_position
    assert np.allclose(moved.drawn.rig.mounts[0].position, declared + effect["parameters"]["translation"], atol=1e-15)


def test_a_clock_that_is_late_shows_the_world_late():
    text = HINGE + "[[effect]]\nname = 'time_offset'\nat = 'imu2'\noffset = 0.05\n"
    imu, plain = make(spec_of(text), 0, 0).recording.imu("imu2"), make(spec_of(HINGE), 0, 0).recording.imu("imu2")
    assert imu.time[0] == pytest.approx(0.05)
    assert np.allclose(imu.gyro, plain.gyro[: len(imu.gyro)], atol=1e-9)  # two grids of the same motion


def test_an_imus_own_errors_stand_in_the_parts_and_not_only_in_the_samples():
    spec = spec_of(HINGE.replace("perfect", "xsens_mtw"))
    drawn = draw(spec, 0, 0)
    part = drawn.parts["imu1"]
    assert part.gyro.bias_std == 0 and np.abs(part.gyro.bias).max() > 0
    assert not np.array_equal(part.gyro.bias, drawn.parts["imu2"].gyro.bias)
    made = make(spec, 0, 0)
    error = made.recording.imu("imu1").gyro - made.truth.sensor("imu1").gyro
    # The mean of 400 noises of std s is within 5 s / 20 of the bias but for one case in a million.
    assert np.abs(error.mean(axis=0) - part.gyro.bias).max() < 5 * part.gyro.noise_std / 20


@pytest.mark.parametrize(
    ("value", "kind", "low", "high"),
    [
        (3, "uniform", 3, 3),
        ([1, 2], "uniform", 1, 2),
        ({"low": 1, "high": 8, "scale": "log"}, "log", 1, 8),
        ({"std": 2, "mean": 1}, "normal", -np.inf, np.inf),
    ],
)
def test_ranges_hold_what_they_draw(value, kind, low, high):
    found = parse_range(value, "x")
    draws = found.draw(np.random.default_rng(0), (2000,))
    assert isinstance(found, Range) and found.kind == kind
    assert (found.low, found.high) == (low, high)
    assert (draws >= low).all() and (draws <= high).all()
    if kind == "normal":
        assert abs(draws.std() - 2) < 0.16  # five standard errors of the std of 2000 draws
    if kind == "log":
        assert abs(np.median(draws) - np.sqrt(8)) < 0.3  # half lie below the geometric mean, within five errors


def test_springs_that_the_motion_throws_about_are_said_with_the_recording():
    text = "seconds = 4\n[[rig]]\nfamily = 'hinge'\nrocking = { frequency = 2, damping_ratio = 0.02 }\n"
    spec = spec_of(text + "[[motion]]\nkind = 'random'\nbandwidth = 8\n")
    with pytest.raises(InputError, match=r"recording 0 of seed 0: sprung mount: expected springs that hold the sensor"):
        make(spec, 0, 0)

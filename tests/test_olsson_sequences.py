"""Sequences: the paper's four, boundaries, reuse of samples, bias removal, hooks, and a user's own file."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose

from imubench import rotations
from imubench.errors import InputError
from imubench.recording import Recording
from imubench.scenarios.olsson2020.motions import MOTIONS, paper_rig
from imubench.scenarios.olsson2020.plan import SEQUENCES, Piece, Plan, find, parse
from imubench.scenarios.olsson2020.sequences import Sequence, add_bias, assemble, join
from imubench.scenarios.olsson2020.session import Session, record
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.profiles import profile
from imubench.sim.rigs import pendulum, springs
from tests.calls import calls

CLOCK = 1e-9  # s, sums of 36,000 steps of 0.02 s

CUT3, CUT10, CUT6 = Piece(3, (0.0, 10.0)), Piece(10, (0.0, 10.0)), Piece(6, (0.0, 20.0))
PAPER = {  # section 7.1, as printed; * and the dagger spelled out
    "sequence1": [Piece(n) for n in range(1, 15)],
    "sequence2": [Piece(1), CUT3, CUT10, *(Piece(n) for n in (8, 2, 9, 3, 10, 4, 11, 5, 12, 6, 13, 7, 14))],
    "sequence3": [CUT6, *(Piece(n) for n in (1, 8, 2, 9))],
    "sequence4": [
        Piece(1), Piece(8), Piece(2, half=1), Piece(9, half=1), CUT6, Piece(2, half=2), Piece(9, half=2),
    ],
}  # fmt: skip
SECONDS = {"sequence1": 700, "sequence2": 720, "sequence3": 220, "sequence4": 220}


@pytest.fixture(scope="module")
def session() -> Session:
    return record(7)


def signals(recording: Recording, start: float, end: float) -> np.ndarray:
    """Both IMUs' samples (2, n, 6) with stamps in [start, end) s."""
    rows = [slice(*np.searchsorted(imu.time, [start - 1e-6, end - 1e-6])) for imu in recording.imus]
    return np.array([np.hstack([i.gyro[r], i.accel[r]]) for i, r in zip(recording.imus, rows, strict=True)])


@pytest.mark.parametrize("name", list(PAPER))
def test_the_sequences_are_the_papers(name, session):
    assert list(SEQUENCES[name].pieces) == PAPER[name]
    sequence = join(SEQUENCES[name], session)
    assert sequence.duration == SECONDS[name]
    assert [s.motion for s in sequence.sections] == [p.motion for p in PAPER[name]]
    for imu in sequence.recording.imus:
        assert_allclose(imu.time, np.arange(50 * SECONDS[name]) / 50, atol=CLOCK)


@pytest.mark.parametrize("name", list(PAPER))
def test_sections_follow_each_other_and_hold_the_samples_of_their_motions(name, session):
    sequence = join(SEQUENCES[name], session)
    assert sequence.sections[0].start == 0
    for section, following in zip(sequence.sections, sequence.sections[1:], strict=False):
        assert section.end == following.start
    for section in sequence.sections:
        start = session.spans[section.motion][0] + section.cut_start
        source = signals(session.recording, start, start + section.end - section.start)
        assert source.shape[1] == round(50 * (section.end - section.start))
        assert np.array_equal(signals(sequence.recording, section.start, section.end), source)


def test_the_cuts_of_3_and_10_hold_motion_of_segment_1_only(session):
    for number in (3, 10):
        start = session.spans[number][0]
        rows = slice(*np.searchsorted(session.truth.time, [start - 1e-6, start + 10 - 1e-6]))
        one, two = (s.gyro[rows] for s in session.truth.sensors)
        assert np.sqrt(np.mean(one**2)) > 0.5
        assert np.abs(two).max() < 1e-12  # rounding of a product of quaternions


def test_two_halves_are_the_motion(session):
    halves = join(Plan("halves", (Piece(2, half=1), Piece(2, half=2))), session)
    whole = join(Plan("whole", (Piece(2),)), session)
    assert [(s.start, s.end, s.cut_start) for s in halves.sections] == [(0, 25, 0), (25, 50, 25)]
    for a, b in zip(halves.recording.imus, whole.recording.imus, strict=True):
        assert np.array_equal(a.gyro, b.gyro)
        assert np.array_equal(a.accel, b.accel)


def same(a: Sequence, b: Sequence) -> bool:
    pairs = zip(a.recording.imus, b.recording.imus, strict=True)
    return all(np.array_equal(x.gyro, y.gyro) and np.array_equal(x.accel, y.accel) for x, y in pairs)


def test_the_seed_decides():
    first = assemble("sequence3", 5)
    assert same(first, assemble("sequence3", 5))
    assert not same(first, assemble("sequence3", 6))
    assert first.recording.name == "sequence3-5"
    assert same(first, join(SEQUENCES["sequence3"], record(5)))  # one session serves all sequences


def test_other_imus_leave_the_motions_as_they_are(session):
    perfect = record(7, imus=replace(profile("perfect"), rate=50.0))
    for a, b in zip(session.truth.sensors, perfect.truth.sensors, strict=True):
        assert np.array_equal(a.gyro, b.gyro)
        assert np.array_equal(a.specific_force, b.specific_force)
    for sensor, imu in zip(perfect.truth.sensors, perfect.recording.imus, strict=True):
        assert np.array_equal(imu.gyro, sensor.gyro)  # no bias to remove: motion 1 reads exactly zero
        assert np.array_equal(imu.accel, sensor.specific_force)


def test_the_gyro_bias_of_motion_1_is_removed_unless_asked_otherwise(session):
    raw = record(7, remove_gyro_bias=False)
    motion1 = Plan("one", (Piece(1),))
    for removed, kept in zip(session.recording.imus, raw.recording.imus, strict=True):
        assert_allclose(
            kept.gyro - removed.gyro, np.tile(session.gyro_bias[kept.name], (kept.time.size, 1)), atol=1e-15
        )
        assert np.linalg.norm(session.gyro_bias[kept.name]) > 1e-3  # the MTw has one: std 0.289 deg/s an axis
        assert np.array_equal(removed.accel, kept.accel)
    for imu in join(motion1, session).recording.imus:
        assert_allclose(imu.gyro.mean(axis=0), 0.0, atol=1e-15)  # rounding
    # The bias is the session's: what is left in motion 8 is the noise of two means over 2500 samples.
    for imu in join(Plan("eight", (Piece(8),)), session).recording.imus:
        assert np.abs(imu.gyro.mean(axis=0)).max() < 5 * np.sqrt(2 / 2500) * imu.gyro_noise_std


def test_constant_errors_are_drawn_once_a_session():
    biased = ImuProfile("biased", 50.0, ChannelProfile(bias_std=0.01), ChannelProfile(bias_std=0.1))
    recorded = record(2, imus=biased, remove_gyro_bias=False)
    for imu, sensor in zip(recorded.recording.imus, recorded.truth.sensors, strict=True):
        for bias in (imu.gyro - sensor.gyro, imu.accel - sensor.specific_force):
            assert np.ptp(bias, axis=0).max() < 1e-12  # rounding of a sum
            assert np.abs(bias).max() > 1e-4
    assert not np.allclose(*(imu.gyro[0] for imu in recorded.recording.imus), atol=1e-4)


def test_a_turned_socket_turns_the_true_axis():
    rig = paper_rig()
    turn = rotations.exp(np.array([0.0, 0.0, 0.02]))
    mounts = (rig.mounts[0], replace(rig.mounts[1], quaternion=turn))
    sequence = assemble("sequence3", 1, rig=replace(rig, mounts=mounts))
    assert_allclose(sequence.axes, [[0, 1, 0], [np.sin(0.02), np.cos(0.02), 0]], atol=1e-12)  # one product
    assert_allclose(sequence.recording.imus[1].mount_position, mounts[1].position, atol=0.03)  # 6 std of the declared


def test_soft_mounts_can_be_played_with_own_durations():
    rig = paper_rig()
    mounts = tuple(replace(m, rotation=springs(15.0, 0.3)) for m in rig.mounts)
    short = dict.fromkeys(MOTIONS, 10.0)
    plan = Plan("short", (Piece(6, half=2), Piece(14)))
    soft = assemble(plan, 1, rig=replace(rig, mounts=mounts), durations=short)
    rigid = assemble(plan, 1, durations=short)
    assert [(s.start, s.end) for s in soft.sections] == [(0, 5), (5, 15)]
    assert not same(soft, rigid)
    assert_allclose(soft.axes, rigid.axes, atol=1e-3)  # they rock by some 1e-3 rad about where they were


def test_a_hook_changes_what_the_sensors_feel(session):
    def shifted(motion, truth, rng):
        if motion.screw:
            return truth
        one, two = truth.sensors
        return replace(truth, sensors=(one, replace(two, gyro=two.gyro + rng.normal())))

    changed = record(7, alter=shifted)
    for number in MOTIONS:
        plan = Plan("one", (Piece(number),))
        assert same(join(plan, changed), join(plan, session)) == MOTIONS[number].screw


@pytest.mark.long
def test_imus_with_a_clock_and_a_filter_of_their_own_keep_every_section_full():
    imu2 = replace(profile("mpu9250"), clock_offset=0.013, clock_skew=1e-4)
    imus = {"imu1": profile("mpu9250"), "imu2": imu2}
    sequence = assemble("sequence3", 1, imus=imus)
    for imu in sequence.recording.imus:
        steps = np.diff(imu.time)
        assert abs(imu.time.size - 22000) <= 5  # at most one sample a boundary
        assert steps.min() > 0
        assert steps.max() < 0.02 + CLOCK


def test_added_bias_has_the_magnitude_asked_for_in_any_direction(session):
    before = join(SEQUENCES["sequence3"], session).recording
    after = add_bias(before, np.random.default_rng(0), gyro=0.02, accel=1.0)
    directions = []
    for a, b in zip(after.imus, before.imus, strict=True):
        for change, size in ((a.gyro - b.gyro, 0.02), (a.accel - b.accel, 1.0)):
            assert_allclose(np.linalg.norm(change, axis=1), size, atol=1e-12)  # rounding of a sum and a difference
            directions.append(change[0] / size)
    assert np.linalg.matrix_rank(np.array(directions)) == 3
    assert not np.allclose(directions[0], directions[2], atol=0.1)
    with pytest.raises(InputError, match="gyro bias: expected a number >= 0, got -1"):
        add_bias(before, np.random.default_rng(0), gyro=-1.0, accel=0.0)


def test_no_sample_of_a_sequence_is_made_by_itself():
    """Motions five times as long take no more calls: what is called works on all samples of a motion."""
    short, long = (
        calls(partial(assemble, "sequence1", 3, durations=dict.fromkeys(MOTIONS, seconds))) for seconds in (10.0, 50.0)
    )
    assert long < 1.05 * short  # of 59,000; a call a sample would be 28,000 more, strokes are some hundred


OWN = """
[warm-up]
summary = "the same stroke again and again"
pieces = [1, { motion = 12, seconds = [5, 7.5], repeat = 3 }, { motion = 2, half = 2 }]
"""


def test_a_users_own_sequence_takes_a_few_lines(tmp_path, session):
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    plan = find(path)
    assert plan.summary == "the same stroke again and again"
    sequence = join(plan, session)
    assert [(s.motion, s.start, s.end, s.cut_start) for s in sequence.sections] == [
        (1, 0.0, 50.0, 0.0), (12, 50.0, 52.5, 5.0), (12, 52.5, 55.0, 5.0), (12, 55.0, 57.5, 5.0), (2, 57.5, 82.5, 25.0),
    ]  # fmt: skip
    strokes = [signals(sequence.recording, t, t + 2.5) for t in (50.0, 52.5, 55.0)]
    assert np.array_equal(strokes[0], strokes[1])
    assert np.array_equal(strokes[0], strokes[2])
    assert same(assemble(path, 7), sequence)
    path.write_text(OWN + "[other]\npieces = [1]\n")
    assert find(f"{path}#other").pieces == (Piece(1),)
    with pytest.raises(InputError, match=r"expected one sequence or .*own.toml#NAME, got warm-up, other$"):
        find(path)
    with pytest.raises(InputError, match=r"^unknown sequence in .*own.toml 'third'; known: warm-up, other$"):
        find(f"{path}#third")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = 1", "own: a: expected a table, got 1"),
        ("[a]\npiece = [1]", "unknown key in own: a 'piece'; known: summary, pieces; did you mean 'pieces'?"),
        ("[a]", "own: a.pieces: expected a list of motions, got None"),
        ("[a]\npieces = []", "own: a.pieces: expected a list of motions, got []"),
        ("[a]\nsummary = 3\npieces = [1]", "own: a.summary: expected a text, got 3"),
        (
            "[a]\npieces = [1, 15]",
            "unknown motion in own: a.pieces[1] '15'; known: 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14",
        ),
        ("[a]\npieces = ['3']", "own: a.pieces[0]: expected a motion's number, got '3'"),
        ("[a]\npieces = [true]", "own: a.pieces[0]: expected a motion's number, got True"),
        ("[a]\npieces = [{ half = 1 }]", "own: a.pieces[0]: expected a motion's number, got None"),
        (
            "[a]\npieces = [{ motion = 3, second = [0, 1] }]",
            "unknown key in own: a.pieces[0] 'second'; known: motion, seconds, half, repeat; did you mean 'seconds'?",
        ),
        ("[a]\npieces = [{ motion = 3, half = 3 }]", "own: a.pieces[0].half: expected 1 or 2, got 3"),
        (
            "[a]\npieces = [{ motion = 3, half = 1, seconds = [0, 1] }]",
            "own: a.pieces[0]: expected seconds or half, got both",
        ),
        (
            "[a]\npieces = [{ motion = 3, repeat = 0 }]",
            "own: a.pieces[0].repeat: expected a whole number of 1 or more, got 0",
        ),
        (
            "[a]\npieces = [{ motion = 3, seconds = [5, 2] }]",
            "own: a.pieces[0].seconds: expected [start, end] with 0 <= start < end, got [5, 2]",
        ),
        (
            "[a]\npieces = [{ motion = 3, seconds = [0, inf] }]",
            "own, key 'a.pieces[0].seconds[1]': expected a finite number, got inf",
        ),
        (
            "[a]\npieces = [{ motion = 3, seconds = 2 }]",
            "own: a.pieces[0].seconds: expected [start, end] with 0 <= start < end, got 2",
        ),
    ],
)
def test_a_bad_file_gets_one_line(text, message):
    with pytest.raises(InputError) as caught:
        parse(text.encode(), "own")
    assert str(caught.value) == message


def test_what_is_no_toml_and_what_is_not_there_says_so(tmp_path):
    with pytest.raises(InputError, match=r"^own: expected TOML, got: "):
        parse(b"[a", "own")
    with pytest.raises(InputError, match=r"^own, line 1: expected UTF-8 text, got byte 0xff$"):
        parse(b"\xff", "own")
    with pytest.raises(InputError, match=r"gone.toml: expected a file, got nothing of that name$"):
        find(tmp_path / "gone.toml")
    with pytest.raises(
        InputError,
        match=r"^unknown sequence 'sequence5'; known: sequence1, .*to a .toml file; did you mean 'sequence\d'\?$",
    ):
        find("sequence5")


def test_cuts_that_a_motion_does_not_hold_say_so(session):
    with pytest.raises(InputError, match=r"^own.pieces\[1\]: expected a cut within the 50 s of motion 6, got 60 s$"):
        join(Plan("own", (Piece(1), Piece(6, (0.0, 60.0)))), session)
    with pytest.raises(InputError, match=r"^own.pieces\[0\]: expected a cut of at least one sample of 0.02 s, got "):
        join(Plan("own", (Piece(6, (1.0, 1.001)),)), session)


def test_a_rig_or_a_duration_that_does_not_fit_says_so():
    with pytest.raises(InputError, match="rig: expected a hinge with two IMUs, got pendulum with 1"):
        record(0, rig=pendulum())
    with pytest.raises(InputError, match="unknown motion '15'; known: 1, 2"):
        record(0, durations={15: 20.0})
    with pytest.raises(InputError, match="duration of motion 4: expected 10 s or more, got 2 s"):
        record(0, durations={4: 2.0})

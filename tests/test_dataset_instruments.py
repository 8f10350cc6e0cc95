"""Encoders and measured poses in datasets: what they read, what is declared, and what comes back from the disk."""

import numpy as np
import pytest

from imubench import rotations
from imubench.dataset import make, parse_spec, read
from imubench.dataset.generate import generate
from imubench.dataset.instruments import followed
from imubench.dataset.shard import Job
from imubench.effects.joints import Backlash
from imubench.errors import InputError

RIGS = "seconds = 20\nrecordings_per_rig = 1\n[[rig]]\nfamily = 'hinge'\n[[rig]]\nfamily = 'pendulum'\n"
ENCODER = "[encoder]\nprobability = 0.5\nnoise_std = 0.001\nzero = [-0.5, 0.5]\n"
POSES = (
    "[[pose]]\nposition_noise_std = 0.002\nrotation_noise_std = 0.01\n"
    "[[pose]]\nsegment = 'segment2'\nprobability = 0.5\nposition_noise_std = 0.001\n"
)
TEXT = RIGS + ENCODER + POSES


def spec_of(text: str):
    return parse_spec({"spec.toml": text.encode()})


def test_they_read_the_truth_with_their_declared_noise():
    spec, encoders, poses = spec_of(TEXT), 0, 0
    for index in range(16):
        made = make(spec, 0, index)
        truth, recording = made.truth, made.recording
        hinge = recording.rig == "hinge"
        assert hinge or not recording.encoders
        for encoder in recording.encoders:
            encoders += 1
            error = encoder.angle + encoder.zero - truth.joint_angle
            assert encoder.zero != 0.0
            # 2000 samples: the std is known to 1.6 %, the mean to 0.022 of it; five times that.
            assert error.std() == pytest.approx(0.001, rel=0.08)
            assert abs(error.mean()) < 0.11 * 0.001
        for pose in recording.poses:
            poses += 1
            segment = truth.segments[int(pose.segment[-1]) - 1]
            off = pose.position - segment.position
            turned = rotations.log(rotations.multiply(rotations.conjugate(segment.quaternion), pose.quaternion))
            assert off.std() == pytest.approx(pose.position_noise_std, rel=0.05)  # 6000 numbers: 0.9 %
            assert turned.std() == pytest.approx(pose.rotation_noise_std, rel=0.05)
        assert "segment1" in [p.segment for p in recording.poses]
        assert hinge or len(recording.poses) == 1
    assert 2 <= encoders < 16
    assert 16 < poses < 32


def test_backlash_follows_as_its_law_does_sample_by_sample():
    angle = np.cumsum(np.random.default_rng(0).standard_normal(1001)) * 0.01
    for play in (0.0, 0.02, 0.1, 10.0):
        assert np.array_equal(followed(angle, play), Backlash.played(angle, play))
    assert followed(angle[:1], 0.1) == angle[0]
    spec = spec_of(RIGS + "[encoder]\nnoise_std = 0\n[[effect]]\nname = 'backlash'\nrange = 0.03\n")
    made = next(m for m in (make(spec, 0, i) for i in range(9)) if m.recording.encoders)
    (encoder,) = made.recording.encoders
    assert np.array_equal(encoder.angle, Backlash.played(made.truth.joint_angle, 0.03))
    assert not any(make(spec, 0, i).drawn.effects for i in range(9) if not make(spec, 0, i).recording.encoders)


def test_other_draws_do_not_move_when_instruments_come():
    plain, more = make(spec_of(RIGS), 0, 3), make(spec_of(TEXT), 0, 3)
    assert np.array_equal(plain.recording.imus[0].gyro, more.recording.imus[0].gyro)


@pytest.mark.parametrize("truth", ["full", "none"])
def test_what_is_stored_comes_back(tmp_path, truth):
    text = f"precision = 'double'\ntruth = '{truth}'\n" + TEXT.replace("seconds = 20", "seconds = 2")
    generate(Job({"spec.toml": text.encode()}, 0, 6, str(tmp_path / "d")), 0)
    for index in range(6):
        stored, made = read(tmp_path / "d", index).recording, make(spec_of(text), 0, index).recording
        assert len(stored.encoders) == len(made.encoders)
        assert [p.segment for p in stored.poses] == [p.segment for p in made.poses]
        for one, other in zip((*stored.encoders, *stored.poses), (*made.encoders, *made.poses), strict=True):
            for key, value in vars(other).items():
                assert np.array_equal(getattr(one, key), value), key


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("encoder = 3\n" + RIGS, "spec.toml: encoder: expected a table, got 3"),
        (RIGS + "[encoder]\nstd = 1", "unknown key in spec.toml: encoder 'std'; known: probability, noise_std, zero"),
        (RIGS + "[[pose]]\nsegment = 'segment3'", "segment 'segment3'; known: segment1, segment2"),
        (RIGS + "[[pose]]\n[[pose]]\n", "pose: expected each segment once, got segment1, segment1"),
        (RIGS + "[[effect]]\nname = 'backlash'", "backlash: expected an [encoder], which it shows in, got none"),
    ],
)
def test_mistakes_are_said_in_one_line(text, message):
    with pytest.raises(InputError) as caught:
        spec_of(text)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)

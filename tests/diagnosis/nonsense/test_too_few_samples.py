"""Too few samples are said with their number."""

from dataclasses import replace

from imubench.diagnosis.nonsense.too_few_samples import too_few_samples
from imubench.recording import Recording
from tests.diagnosis.nonsense.recordings import said


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

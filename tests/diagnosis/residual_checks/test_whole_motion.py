"""The motion of a fit that saw filtered samples, before the first and after the last of them."""

import numpy as np
import pytest

from imubench.diagnosis.candidates.begin import begin
from imubench.diagnosis.noise.decimation import at_rate
from imubench.diagnosis.residual_checks.fit_summary import played
from imubench.diagnosis.residual_checks.whole_motion import to_the_ends
from imubench.format1 import read
from imubench.recording import span_of
from tests.regressions.recordings import Blind, Made


@pytest.mark.slow
@pytest.mark.parametrize("making", [Made("hinge", (), 31, 20.0, {"rate": 100.0}), Blind(7, 20, 5)])
def test_the_motion_follows_the_recording_s_own_samples_at_both_ends(tmp_path, making):
    """The second one's fit has knots that end before the recording does."""
    making.write(tmp_path / "r")
    recording = read(tmp_path / "r")[0]
    fit = begin(recording).first
    seen = fit.model.recording.imus[0].time
    assert at_rate(recording.imus[0], fit.model.recording.imus[0].rate)[0].time[0] == seen[0]  # fewer samples
    whole = to_the_ends(fit, recording)
    rows = played(whole).time
    assert (rows[0], rows[-1]) == pytest.approx(span_of(recording), abs=1.0)
    assert rows[0] < span_of(recording)[0] < span_of(recording)[1] < rows[-1]
    imu = recording.imus[0]
    for ends in (imu.time < seen[0], imu.time > seen[-1]):
        assert ends.sum() > 10
        off = [_off(one, recording, imu.name)[ends] for one in (fit, whole)]
        assert np.sqrt(np.mean(off[1] ** 2)) < 1.7  # times the noise; its knots are those of slower samples
        assert np.sqrt(np.mean(off[0] ** 2)) > 20.0  # what a spline without samples does
    inside = (imu.time >= seen[0] + 1) & (imu.time <= seen[-1] - 1)
    assert _off(whole, recording, imu.name)[inside] == pytest.approx(_off(fit, recording, imu.name)[inside], abs=0.05)


def _off(fit, recording, name):
    """What a fit's motion has a gyroscope read (n, 3) less what it read, over its noise."""
    imu = next(i for i in recording.imus if i.name == name)
    moment = fit.model.moment(fit.state, imu.time, name)
    reading = fit.model.reading(imu, fit.state, moment, fit.model.carrier(fit.state, moment, name))
    return (reading.gyro.value - imu.gyro) / imu.gyro_noise_std

"""Does what is left go with the motion at all? A cheap look before effects with a life of their own are tried.

White noise knows nothing of the motion. A sensor on springs, a filter, a loose joint leave residuals that
follow from it by some linear law; so each residual channel is regressed on the motion's signals around
the same moment, and what that gains is compared with what chance would gain.

The fitted motion holds some of the noise of the very samples that it leaves residuals of, and goes with them by that
alone. It is the motion up to the frequency at which it falls to a few times the noise that may be asked, below a hum.
"""

from dataclasses import replace

import numpy as np
from scipy.signal import butter, sosfiltfilt, welch
from scipy.stats import chi2

from imubench.arrays import Array
from imubench.diagnosis.config.noise import COHERENCE
from imubench.diagnosis.config.samples import TONE
from imubench.diagnosis.config.shared import STATISTICS
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.samples.rest_noise import quiet_noise
from imubench.recording import Imu

SENSED = {"gyro": "rate", "accel": "force"}  # of a motion


def follows_motion(fit: Fit) -> dict[str, float]:
    """Return, per group of measurements, twice the largest gain of its channels over the value that chance exceeds.

    Above 1 the residuals go with the motion.
    """
    model, out = fit.model, {}
    for rows in fit.measured:
        sensor = rows.name.split(".")[0]
        imu = next((i for i in model.recording.imus if i.name == sensor), None)
        if imu is None:
            continue
        signals = [*_motion(fit, imu, rows.time + model.start).values()]
        cut = min(clear_in(fit, imu, "gyro"), COHERENCE.below_hum * model.humming.get(sensor, np.inf))
        out[rows.name] = _gain(rows.whitened, slower(np.concatenate(signals, axis=1), cut, imu.rate))
    return out


def clear_at(fit: Fit, name: str) -> float:
    """Return the frequency in Hz up to which the fitted motion of an IMU, or what pushes it, is more than noise."""
    imu = fit.model.recording.imu(name)
    cut = max(clear_in(fit, imu, part) for part in SENSED)
    return min(cut, COHERENCE.below_hum * fit.model.humming.get(name, np.inf))


def _motion(fit: Fit, imu: Imu, stamps: Array) -> dict[str, Array]:
    """Return a sensor's rate, angular acceleration and specific force (n, 3) as fitted, at stamps (n,) s."""
    model, state = fit.model, fit.state
    moment = model.moment(state, stamps, imu.name)
    segment = model.carrier(state, moment, imu.name)
    motion = segment.child(model.mount(imu, state, moment, segment))
    each = {"rate": motion.rate, "accel": motion.accel, "force": motion.force}
    return {key: np.broadcast_to(s.value, (len(stamps), 3)) for key, s in each.items()}


def clear_in(fit: Fit, imu: Imu, part: str) -> float:
    """Return the frequency in Hz up to which what an IMU's gyro or accel senses as fitted is more than its noise.

    At even times: a gap is a step at every frequency, and a motion of 1 Hz looked clear at all of them. So is a slip,
    which is no motion of splines: effects without states are left out.
    """
    moving = tuple(h for h in fit.model.hypotheses if h.effect.states)
    splines = replace(fit, model=replace(fit.model, hypotheses=moving))
    signal = _motion(splines, imu, even_stamps(imu))[SENSED[part]]
    quiet = quiet_noise(imu, part)
    noise = min(fit.noise.get(f"{imu.name}.{part}", quiet), quiet)  # not in the fit where no sample counts
    return clear_of_noise(signal, noise, imu.rate)


def even_stamps(imu: Imu) -> Array:
    """Return even stamps (n,) s of an IMU at its rate, through the gaps of its samples too."""
    first, last = imu.time[0], imu.time[-1]
    return np.asarray(np.linspace(first, last, round((last - first) * imu.rate) + 1))


def clear_of_noise(signal: Array, noise: float, sampling: float) -> float:
    """Return the frequency in Hz up to which a fitted signal (n, 3) is more than the noise of its sensor.

    `noise` is its standard deviation, in the signal's unit; `sampling` in Hz.
    """
    f, power = welch(signal, sampling, nperseg=min(256, max(len(signal) // 8, 16)), axis=0)
    loud = power.sum(axis=1) > TONE.moved_power * 3 * 2 * noise**2 / sampling
    clear = f[loud & (f <= COHERENCE.most_of_rate * sampling)]
    return float(max(clear[-1], COHERENCE.least_hz)) if clear.size else COHERENCE.least_hz


def slower(signals: Array, cut: float, sampling: float) -> Array:
    """Return signals (n, k) without what is faster than `cut` Hz; all of them where that is near half the sampling."""
    if cut > COHERENCE.most_of_rate * sampling:
        return signals
    sos = butter(4, cut, fs=sampling, output="sos")
    ends = 3 * (2 * len(sos) + 1)  # samples, by which the filter lets signals go on at either end
    return signals if len(signals) <= ends else np.asarray(sosfiltfilt(sos, signals, axis=0))


def _gain(residual: Array, signals: Array) -> float:
    """Return the largest gain of a channel (n, k) from signals (n, m) and their lags, over its critical value.

    None of fewer samples than there are signals to explain them, as of a sensor that clips nearly throughout.
    """
    edge = max(COHERENCE.lags)
    if len(residual) - 2 * edge <= len(COHERENCE.lags) * signals.shape[1] + 1:
        return 0.0
    lagged = [np.roll(signals, -lag, axis=0)[edge:-edge] for lag in COHERENCE.lags]
    x = np.concatenate([*lagged, np.ones((len(signals) - 2 * edge, 1))], axis=1)
    x = x / np.maximum(np.linalg.norm(x, axis=0), 1e-12)
    u, s, _ = np.linalg.svd(x, full_matrices=False)
    u = u[:, s > 1e-6 * s[0]]
    y = residual[edge:-edge]
    y = y / np.sqrt(np.mean(y**2, axis=0))
    return float(np.max(np.sum((u.T @ y) ** 2, axis=0)) / chi2.isf(STATISTICS.false_alarm_of_one, u.shape[1]))


__all__ = ["clear_at", "clear_in", "clear_of_noise", "even_stamps", "follows_motion", "slower"]

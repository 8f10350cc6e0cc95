"""The noise levels that a recording declares, and what a fit leaves against them."""

import numpy as np

from imubench.diagnosis.problem.batch_model import Model
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.problem.hypothesis import Hypothesis
from imubench.diagnosis.samples.rest_noise import quietest
from imubench.recording import Recording


def declared(model: Model) -> dict[str, float]:
    """Return the noise levels that a model's recording declares, by group."""
    return declared_by(model.recording)


def declared_by(recording: Recording) -> dict[str, float]:
    """Return the noise levels that a recording declares, by group."""
    out: dict[str, float | None] = {}
    for imu in recording.imus:
        out |= {f"{imu.name}.gyro": imu.gyro_noise_std, f"{imu.name}.accel": imu.accel_noise_std}
    for encoder in recording.encoders:
        out["encoder.angle"] = encoder.angle_noise_std
    for i, pose in enumerate(recording.poses):
        out |= {f"pose{i + 1}.position": pose.position_noise_std, f"pose{i + 1}.rotation": pose.rotation_noise_std}
    return {name: std for name, std in out.items() if std}


def misfit(fit: Fit, at_least: bool = False) -> float:
    """Return the mean over the sensors of noise power left over noise power expected.

    Expected is what is declared, or where nothing is what the IMU leaves in its quietest moments, if that may be an
    IMU's noise. One that hums has louder moments (its gyroscope turns with the hum): undeclared, its level says
    nothing. `at_least`: over the louder of both, for what is declared may be too little.
    """
    steady = tuple(i for i in fit.model.recording.imus if i.name not in fit.model.humming)
    quiet = quietest(steady)
    told = quiet | declared(fit.model)
    if at_least:
        told = {name: max(std, quiet.get(name, 0.0)) for name, std in told.items()}
    power = {n: (fit.noise[n] / std) ** 2 for n, std in told.items() if n in fit.noise}
    return float(np.mean([fit.model.averaging.power(n, p) for n, p in power.items()] or [1.0]))


def breaks_its_law(fit: Fit, h: Hypothesis) -> bool:
    """Return whether an effect's states leave more of their law than it allows, and so are splines.

    A filter's own readings break its law by a tenth of its std; readings that a filter cannot make leave several.
    """
    return any(std > 1.0 for name, std in fit.noise.items() if h.effect.lawful and name.startswith(h.key("")))

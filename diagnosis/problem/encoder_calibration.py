"""What an encoder reads beside the joint's angle: its zero, and the error of a disc that is not quite round.

A free swing on a fixed base shows both: gravity tells where down is, and an error e(q) that comes again with every
turn looks like a torque that grows with the square of the rate, w^2 e''(q). Neither is a law that the model left out.
"""

import numpy as np

from imubench.arrays import Array
from imubench.diagnosis.config.solve import MOTION_PRIOR
from imubench.jets import Jet
from imubench.recording import Recording

ERROR = "encoder.error"  # the fit's name for a zero and pairs of sine and cosine


def misreads(recording: Recording) -> bool:
    """Return whether a recording shows its encoder's error: nothing else says where gravity pulls, and how it moves."""
    swings = bool(recording.free_swings) and recording.body is not None
    return swings and bool(recording.encoders) and recording.clamped


def spread() -> Array:
    """Return the standard deviations (1 + 2 encoder_waves,) rad that are held plausible."""
    waves = MOTION_PRIOR.encoder_wave_rad / np.repeat(np.arange(1, MOTION_PRIOR.encoder_waves + 1, dtype=float), 2) ** 2
    return np.concatenate([[MOTION_PRIOR.encoder_zero_rad], waves])


def read(angle: Jet, error: Jet) -> Jet:
    """Return what the encoder says (n, 1) rad of an angle (n, 1) rad; error (1, 1 + 2 encoder_waves) rad."""
    out, q = angle + error[[0]], angle.value
    for k in range(1, MOTION_PRIOR.encoder_waves + 1):
        sine, cosine = np.sin(k * q), np.cos(k * q)
        out = out + error[[2 * k - 1]] * angle.through(sine, k * cosine)
        out = out + error[[2 * k]] * angle.through(cosine, -k * sine)
    return out


__all__ = ["ERROR", "misreads", "read", "spread"]

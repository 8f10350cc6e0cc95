"""The single pendulum of MultiArm-Pendulum: a real arm swinging down, encoder only.

Source: Kaheman et al., "The experimental multi-arm pendulum on a cart", arXiv 2205.06231;
github.com/dynamicslab/MultiArm-Pendulum, MIT licence.
"""

from pathlib import Path

import numpy as np

from imubench.arrays import Array, frozen, frozen_time
from imubench.convert.converter import Converted, Converter, Option
from imubench.errors import InputError, unknown
from imubench.inputs.mat import read_mat
from imubench.recording import STANDARD_GRAVITY, Body, Encoder, Recording

UPRIGHT = (float(np.sqrt(0.5)), 0.0, -float(np.sqrt(0.5)), 0.0)
"""Segment 1 -> world, -90 deg about +y: segment 2, along +x at hinge angle 0, then points up.

So the hinge angle is the dataset's angle from upright, and at pi the arm hangs.
"""

SLENDER = 1e-3  # of a rod's inertia across it: that about its own length, which no swing shows
SMOOTH = 0.05  # s over which the angle is taken for a quintic


def convert(source: Path, piece: str = "all") -> list[Converted]:
    """Return each piece of the file, or one, as a free swing of a hinge with a fixed base.

    `source` is SinglePendulumDataForParameterEstimation.mat. Its rate channel serves only as a check: raises
    `InputError` unless it is the derivative of the angle, and unless the arm hangs at pi.
    """
    pieces = _read(source)
    if piece != "all" and piece not in pieces:
        raise unknown("piece", piece, ("all", *pieces))
    return [_convert_piece(source, name, *pieces[name]) for name in pieces if piece in ("all", name)]


def _convert_piece(source: Path, name: str, time: Array, angle: Array, rate: Array) -> Converted:
    misfit = float(np.sqrt(np.mean((np.gradient(angle, time) - rate) ** 2) / np.mean(rate**2)))
    if not misfit < 0.05:  # 0.8 to 1.8 % in the dataset, from the noise of differences
        raise InputError(
            f"{source}, piece {name}: expected a rate that is the derivative of the angle, "
            f"got a difference of {misfit:.0%} of the rate's RMS"
        )
    middle = float((angle.min() + angle.max()) / 2)
    if abs(middle - np.pi) > 0.5:
        raise InputError(f"{source}, piece {name}: expected a swing about pi (hanging), got one about {middle:.2f} rad")
    encoder = Encoder(joint="hinge", time=time, angle=angle)
    body = rod(time, angle)
    recording = Recording(
        name=f"multiarm-{name}",
        rig="hinge",
        motion="free",
        base="fixed",
        base_quaternion=np.array(UPRIGHT),
        encoders=(encoder,),
        free_swings=((float(time[0]), float(time[-1])),),
        body=body,
    )
    hertz = 1 / float(np.median(np.diff(time)))
    note = (
        f"Piece {name} of the single pendulum, dynamicslab MultiArm-Pendulum (arXiv 2205.06231), MIT licence. "
        f"Encoder at {hertz:.0f} Hz, smoothed at the source (it steps by under 1e-7 rad); 0 is upright. "
        f"The stored rate agrees with the derivative of the angle to {misfit:.1%} of its RMS and is not kept. "
        f"Mass and length are not given: the body is a uniform rod of 1 kg as long as the swing's period asks, "
        f"{2 * body.com[0]:.4f} m; torques are those of such a rod."
    )
    return Converted(recording, None, note)


def rod(time: Array, angle: Array) -> Body:
    """Return a uniform rod of 1 kg along +x that swings about its end as fast as a measured angle (n,) rad.

    Least squares of q'' = k sin q + c q' + t sign q' + d |q'| q' + e, q from upright, give k = 3 g / (2 length).
    """
    from scipy.signal import savgol_filter  # here: long to import, and most commands do without

    step = float(np.median(np.diff(time)))
    window = 2 * max(int(SMOOTH / step / 2), 2) + 1
    rate, accel = (savgol_filter(angle, window, 5, order, step)[window:-window] for order in (1, 2))
    q = angle[window:-window]
    columns = np.stack([np.sin(q), rate, np.sign(rate), np.abs(rate) * rate, np.ones(q.size)], axis=1)
    k = float(np.linalg.lstsq(columns, accel, rcond=None)[0][0])
    half = 0.75 * STANDARD_GRAVITY / k
    across = half**2 / 3
    return Body(1.0, np.array([half, 0.0, 0.0]), np.array([SLENDER * across, across, across]))


def _read(path: Path) -> dict[str, tuple[Array, Array, Array]]:
    """Return time (n,) s, angle (n,) rad and rate (n,) rad/s of each piece: id-1, ..., vad-1, ..."""
    content = read_mat(path, [f"{what}_{kind}" for kind in ("id", "vad") for what in ("Time", "Y")])
    pieces = {}
    for kind in ("id", "vad"):
        times, values = (np.ravel(content[f"{what}_{kind}"]) for what in ("Time", "Y"))
        if times.dtype != object or values.dtype != object or len(times) != len(values):
            raise InputError(f"{path}: expected Time_{kind} and Y_{kind} to be cells of equal number")
        for i, (time, value) in enumerate(zip(times, values, strict=True)):
            name = f"{kind}-{i + 1}"
            stamps = frozen_time(np.ravel(time), f"{path}, piece {name}, time")
            angle, rate = frozen(value, (2, stamps.size), f"{path}, piece {name}, angle and rate")
            pieces[name] = (stamps, angle, rate)
    return pieces


CONVERTER = Converter(
    "multiarm",
    "the single pendulum of MultiArm-Pendulum (.mat): an encoder in free swings",
    convert,
    {"piece": Option("one piece, such as id-1 or vad-2, or all", str)},
)

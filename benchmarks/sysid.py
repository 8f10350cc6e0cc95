"""Every parameter set free in MuJoCo's own system identification, beside the diagnosis.  python -m benchmarks sysid

A hinge with two IMUs swings freely with one effect concealed (independent generator). `mujoco.sysid` gets more than
the diagnosis: the true state at the start, which is no parameter of it, both IMUs on one time grid, and the level of
the noise. Free are gain and bias of every gyroscope and accelerometer, delay and mount of each IMU, gravity, and the
joint's inertia, damping, drag, dry friction and spring: of the contract's table what it can express. It says an effect
where a parameter is five standard deviations from what is declared. Needs the extra `bench`.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from benchmarks.sysid_free import identify
from benchmarks.table import Row
from imubench.diagnosis.pipeline import diagnose
from imubench.format1 import read
from imubench.proof.case import build
from imubench.proof.filed import write

CASES: tuple[tuple[str, str] | None, ...] = (
    None,
    ("viscous_friction", "joint"),
    ("dry_friction", "joint"),
    ("gyro_bias", "imu2"),
    ("gyro_scale", "imu2"),
    ("accel_bias", "imu2"),
    ("time_offset", "imu2"),
    ("rocking_mount", "imu2"),
)
SEED, SECONDS, SAID, TOLD = 17, 15.0, 0.5, 4


def asked(effect: tuple[str, str] | None) -> Row:
    """Return the row of one concealed effect."""
    case = build(
        "hinge",
        [effect] if effect else [],
        SEED,
        base="fixed",
        swing=True,
        seconds=SECONDS,
        rate=100.0,
    )
    with tempfile.TemporaryDirectory() as scratch:
        write(case, Path(scratch) / "r")
        recording = read(Path(scratch) / "r")[0]
    at = int(np.searchsorted(case.world.t, recording.free_swings[0][0]))
    begun = time.process_time()
    found, _ = diagnose(recording)
    ours = time.process_time() - begun
    said = [f"{f.effect}@{f.at}" for f in found.findings if f.confidence >= SAID]
    begun = time.process_time()
    try:
        theirs = identify(recording, float(case.world.angle[0][at]), float(case.world.angle[1][at]))
        told, misfit, free = theirs.said, f"residual {theirs.misfit:.2f} of the noise", theirs.parameters
    except ValueError as error:  # a rollout that diverges ends its optimiser
        told, misfit, free = (), f"ended: {error}", 0
    spent = time.process_time() - begun
    truth = "@".join(effect) if effect else "nothing"
    more = f" and {len(told) - TOLD} more" if len(told) > TOLD else ""
    return Row(
        f"swinging hinge, concealed: {truth}. Said, and processor time; peer: mujoco.sysid, {free} numbers free",
        f"{', '.join(said) or 'nothing'}; {ours:.0f} s",
        f"{', '.join(told[:TOLD]) or 'nothing'}{more}; {misfit}; {spent:.0f} s",
        f"{spent / ours:.1f}",
        "the truth alone",
        said == ([truth] if effect else []),
    )


def run() -> list[Row]:
    """Return a row for each concealed effect."""
    rows = []
    for k, effect in enumerate(CASES, 1):
        print(f"sysid: {k} of {len(CASES)}, {'@'.join(effect) if effect else 'nothing'}", file=sys.stderr)
        rows.append(asked(effect))
    return rows

"""What concealed effects add to every channel of an IMU, and how much of it a declared model cannot take up.

Let d be the samples with the effects less those without them, over the noise: one motion, no noise. G is the change of
the samples by the mounts, with s what is declared of them, and A that by a motion which is free up to a band (`sight`).

    moved by hand       left = d - A x - G g,    x, g = argmin |d - A x - G g|^2 + |g / s|^2
    swinging free       left = d - G g,          g = argmin |d - G g|^2 + |g / s|^2

A hand's motion is known from the samples alone, so it may take part of d for itself; whatever motion is recovered, the
declared model is off by `left` at least. In a free swing d is between the swing as it was and one by the remaining
forces, let go in the true state at the start of every window; no motion takes that up.

Not asked is what has no mean (louder noise, rounding, lost samples), what samples that do not count would show (a
clipped one, a knock), and where a mount is: a declared model finds that by itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from imubench.proof.linearised import Block, blocks
from imubench.proof.options import Effect
from imubench.proof.played import Case, sensed
from imubench.proof.resumed import Windows, resumed
from imubench.proof.rotation import Array
from imubench.proof.sight import Sight, as_they_are, channels, geometry, noise_of, sight, stacked

NOT_ASKED = (
    "gyro_noise", "accel_noise", "quantisation", "dropouts", "thermal_walk", "saturation", "impacts", "mount_pose",
)  # fmt: skip
ALIKE = "mount_pose"  # which both sides have; the others of NOT_ASKED neither has
AXES = {"gyro": "gyr", "accel": "acc"}
MARGIN = 0.05  # s at a window's ends: there a swing that was let go anew jumps


@dataclass(frozen=True)
class Excess:
    """What effects add to one channel."""

    concealed: float  # RMS of d, in the channel's unit
    left: float  # RMS of what the declared model cannot take up
    noise: float  # std of a sample
    samples: int

    @property
    def deviations(self) -> float:
        """How many standard deviations of the noise all samples together are off."""
        return self.left / self.noise * float(np.sqrt(self.samples))


def excess(case: Case, windows: Sequence[tuple[float, float]] = ()) -> dict[str, Excess]:
    """Return what a case's effects add, by channel ("imu2.gyr_y"); {} where none is asked.

    Args:
        case: with everything in it.
        windows: s, of free swings that are judged; () for all of them.
    """
    told = [e for e in case.effects if e.effect not in NOT_ASKED or e.effect == ALIKE]
    rest = [e for e in told if e.effect == ALIKE]
    if len(told) == len(rest):
        return {}
    case = replace(case, options=replace(case.options, colour=0.0))
    if case.options.swing:
        return _swinging(case, told, rest, list(windows) or case.world.swings)
    seen = sight(case)
    assert seen is not None  # free swings alone have none
    d = seen.readings(told) - seen.readings(rest)
    left = seen.left(d[:, None])[:, 0]
    return _by_channel(seen.parts, d, left - _geometry_part(seen.G, seen.prior, left))


def _swinging(case: Case, told: list[Effect], rest: list[Effect], windows: Windows) -> dict[str, Excess]:
    options = replace(case.options, noise=0.0, gaps=0, repeats=0)
    plain = replace(sensed(options, [], case.seed, case.world), mounts=as_they_are(case))
    parts = blocks(plain, {name: noise_of(case, name) for name in channels(plain)})
    other = resumed(case.world, options, rest, case.seed, windows)
    own = np.concatenate([np.repeat(_inside(part.time, windows), 3) for part in parts])
    both = (sensed(options, effects, case.seed, world) for effects, world in ((told, case.world), (rest, other)))
    with_it, without = (stacked(one, parts) for one in both)
    d = np.where(own, with_it - without, 0.0)
    G, prior = geometry(Sight(plain, parts, None, None, np.zeros((own.size, 0)), np.zeros(0)))
    G = np.where(own[:, None], G, 0.0)
    return _by_channel(parts, d, d - _geometry_part(G, prior, d), own)


def _geometry_part(G: Array, prior: Array, change: Array) -> Array:
    """Return what the mounts take up of a change (rows,)."""
    return np.asarray(G @ np.linalg.solve(G.T @ G + np.diag(prior), G.T @ change))


def _inside(time: Array, windows: Windows) -> NDArray[np.bool_]:
    return np.any([(time >= start + MARGIN) & (time <= end - MARGIN) for start, end in windows], axis=0)


def _by_channel(parts: list[Block], d: Array, left: Array, own: NDArray[np.bool_] | None = None) -> dict[str, Excess]:
    """Return the RMS of whitened changes (rows,) by channel of an IMU, over the rows that are its own."""
    out, first = {}, 0
    for part in parts:
        rows = slice(first, first + part.S[0].shape[0] * part.S[0].shape[1])
        first = rows.stop
        imu, _, triple = part.name.partition(".")
        if triple not in AXES:
            continue
        counts = np.ones(rows.stop - rows.start, dtype=bool) if own is None else own[rows]
        kept = counts.reshape(-1, 3)[:, 0]
        for k, axis in enumerate("xyz"):
            size, rest = (float(np.sqrt(np.mean(x[rows].reshape(-1, 3)[kept, k] ** 2))) * part.std for x in (d, left))
            out[f"{imu}.{AXES[triple]}_{axis}"] = Excess(size, rest, part.std, int(kept.sum()))
    return out


__all__ = ["NOT_ASKED", "Excess", "excess"]

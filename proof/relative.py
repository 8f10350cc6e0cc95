"""Limits and angles that are drawn relative to the motion: a saturation's, a stop's, a spring's."""

from dataclasses import replace

import numpy as np

from imubench.proof.frames import grid
from imubench.proof.options import Effect, Options
from imubench.proof.played import moved, played

NEARER = 0.85  # of its angle from hanging: where a stop that was not touched is tried next


def settled(options: Options, effects: list[Effect], seed: int) -> list[Effect]:
    """Return the effects with limits and angles that were drawn relative to the motion.

    `share` of the largest reading becomes the `limit` of a saturation; `from_rest` becomes the `angle` of a stop or
    the `q0` of a spring.
    """
    open_ones = [e for e in effects if {"share_of_peak", "from_rest"} & set(e.parameters)]
    if not open_ones:
        return effects
    rest = [e for e in effects if e not in open_ones]
    if all("from_rest" in e.parameters for e in open_ones):
        hangs, case = moved(options, rest, grid(options.seconds), seed).hangs, None
    else:
        case = played(options, rest, seed)
        hangs = case.world.hangs
    done = []
    for e in effects:
        p = dict(e.parameters)
        if case and "share_of_peak" in p:
            samples = case.imus[int(e.at[-1]) - 1]
            peak = max(float(np.abs(getattr(samples, channel)).max()) for channel in p["channels"])
            p = {"limit": p["share_of_peak"] * peak, "channels": p["channels"]}
        elif "from_rest" in p:
            off = p.pop("from_rest")
            if e.effect == "end_stop":  # the sign of its angle is its side: it must not be on the way to hanging
                off = off if off * (hangs + off) > 0 else -off
                p["angle"] = hangs + touched(options, rest, hangs, off, seed)
            else:
                p["q0"] = hangs + off
        done.append(replace(e, parameters=p))
    return done


def touched(options: Options, rest: list[Effect], hangs: float, off: float, seed: int) -> float:
    """Return how far (rad) from hanging a stop is: `off`, or as much nearer as the swing needs to touch it.

    A stop that nothing touches changes no sample, and nobody could find it. Its angle keeps its sign.
    """
    t = grid(options.seconds)
    nearer = off
    while nearer * (hangs + nearer) > 0 and abs(nearer) > 0.1 * abs(off):
        stop = Effect("end_stop", "joint", {"angle": hangs + nearer}, True)
        world = moved(options, [*rest, stop], t, seed)
        inside = np.any([(t >= a) & (t <= b) for a, b in world.swings], axis=0)
        if np.any((world.angle[0][inside] - hangs) * np.sign(off) > abs(nearer)):
            return nearer
        nearer *= NEARER
    return off

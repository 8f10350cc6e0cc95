"""What recording `i` of a dataset is: drawn from (spec, seed, i) alone, whoever asks, in whatever order.

Every rig and every recording has a NumPy SeedSequence of its own, keyed by what it is and by its number; within it,
every part has a generator of its own. Rig r is that of the recordings r n to r n + n - 1, n per rig.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from imubench import rotations
from imubench.dataset.effect_ranges import Shown
from imubench.dataset.imu_choices import bought
from imubench.dataset.instruments import DrawnEncoder, DrawnPose
from imubench.dataset.motion_ranges import BEYOND
from imubench.dataset.ranges import located
from imubench.dataset.rig_ranges import DrawnRig, draw_rig, pick
from imubench.dataset.spec import Spec
from imubench.dataset.swing_range import FreeSwing, hanging
from imubench.models.tree import rig_tree
from imubench.recording import Body
from imubench.sim.imu_model import DeclaredMount
from imubench.sim.imu_profile import ImuProfile
from imubench.sim.injected import believed, carried, injected_profile, injected_rig
from imubench.sim.motion import Motion
from imubench.sim.rigs import Mount, Rig

RIG, RECORDING, SPLIT = 0, 1, 2  # the first number of a key
PARTS = ("seconds", "motion", "imus", "declared", "effects", "observing", "samples", "instruments", "pivot")
"""What draws within a recording: append new parts at the end, or old seeds give other recordings."""
GOLDEN = 0.6180339887498949  # a step that spreads splits evenly over the rigs, however many there are
STEPS = 3.0  # of the golden ratio meet any interval of length f at least once in 3 / f: its gaps are 1 to 2.62 times f
FEW = 50_000  # rigs that are looked at: half a second


@dataclass(frozen=True)
class Drawn:
    """Everything about one recording before it is played."""

    index: int
    rig_index: int
    split: str
    seconds: float
    rig: Rig  # as it is: mounts moved and on springs, gravity the true one
    declared_gravity: float  # m/s^2
    declared: Mapping[str, DeclaredMount]  # by sensor
    motion_name: str
    motion: Motion | FreeSwing
    body: Body | None  # of a free swing, as declared
    encoder: DrawnEncoder | None
    poses: tuple[DrawnPose, ...]
    parts: Mapping[str, ImuProfile]  # by sensor, effects included
    nominal: Mapping[str, ImuProfile]  # by sensor, the same parts without effects
    effects: tuple[dict[str, Any], ...]  # {"effect", "at", "parameters"}
    streams: Mapping[str, np.random.Generator]  # PARTS


def generator(seed: int, *key: int) -> np.random.Generator:
    """Return the generator of a key."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=key))


def rig_of(spec: Spec, seed: int, rig_index: int) -> tuple[int, DrawnRig]:
    """Return which `[[rig]]` of the spec a rig comes from, and the rig."""
    rng = generator(seed, RIG, rig_index)
    which = pick([rig.weight for rig in spec.rigs], rng)
    with located(f"rig {rig_index} of seed {seed}, rig[{which}]"):
        return which, draw_rig(spec.rigs[which], rng)


def split_of(spec: Spec, seed: int, rig_index: int) -> str:
    """Return a rig's split: of any m rigs in a row, each split gets its fraction of m within about one."""
    start = _split_start(seed)
    edges = np.cumsum(list(spec.splits.values()))
    which = int(np.searchsorted(edges, (start + GOLDEN * rig_index) % 1.0, side="right"))
    names = [name for name, fraction in spec.splits.items() if fraction]
    return list(spec.splits)[which] if which < len(edges) else names[-1]


@lru_cache(maxsize=4)
def _split_start(seed: int) -> float:
    return float(generator(seed, SPLIT).random())


def first_rigs(spec: Spec, seed: int) -> dict[str, int]:
    """Return the first rig of each split that has a fraction; of the smallest fractions, none within `FEW` rigs."""
    least = min(fraction for fraction in spec.splits.values() if fraction)
    found: dict[str, int] = {}
    for rig in range(min(FEW, int(STEPS / least) + 1)):
        found.setdefault(split_of(spec, seed, rig), rig)
        if len(found) == sum(fraction > 0 for fraction in spec.splits.values()):
            break
    return found


def draw(spec: Spec, seed: int, index: int) -> Drawn:
    """Return recording `index`; `InputError` where the numbers drawn make no rig."""
    rig_index = index // spec.recordings_per_rig
    which, drawn = rig_of(spec, seed, rig_index)
    streams = dict(zip(PARTS, generator(seed, RECORDING, index).spawn(len(PARTS)), strict=True))
    seconds = round(spec.seconds.one(streams["seconds"]) * spec.rate) / spec.rate
    suited = [m for m in spec.motions if m.suits(spec.rigs[which])]
    chosen = suited[pick([m.weight for m in suited], streams["motion"])]
    name, motion = chosen.draw(streams["motion"], seconds + BEYOND)
    sensors = [f"imu{i + 1}" for i in range(len(drawn.rig.mounts))]
    encoder, poses = _instruments(spec, streams["instruments"], drawn.rig.family)
    shown = Shown(drawn.rig.family, isinstance(motion, FreeSwing), encoder is not None)
    effects = (*drawn.springs, *(_from_rest(e, drawn.rig) for e in _effects(spec, streams["effects"], shown, seconds)))
    with located(f"recording {index} of seed {seed}"):
        nominal = _parts(spec, streams["imus"], sensors)
        parts = {at: injected_profile(nominal[at], at, effects) for at in sensors}
        declared = {
            at: _measured(spec, m, streams["declared"]) for at, m in zip(sensors, drawn.rig.mounts, strict=True)
        }
        rig = injected_rig(drawn.rig, declared, effects)
        if not isinstance(motion, FreeSwing):
            motion, rig = carried(motion, rig, effects, streams["pivot"])
        body = believed(rig.segments[-1], effects) if isinstance(motion, FreeSwing) else None
    split = split_of(spec, seed, rig_index)
    return Drawn(
        index,
        rig_index,
        split,
        seconds,
        rig,
        drawn.rig.gravity,
        declared,
        name,
        motion,
        body,
        encoder,
        poses,
        parts,
        nominal,
        effects,
        streams,
    )


def _effects(spec: Spec, rng: np.random.Generator, shown: Shown, seconds: float) -> list[dict[str, Any]]:
    places = (*rig_tree(shown.family).imus, "joint", "body", "world")
    own = zip(spec.effects, rng.spawn(len(spec.effects)), strict=True)
    return [found for e, stream in own if e.suits(shown) for found in e.draw(stream, places, seconds)]


def _from_rest(effect: dict[str, Any], rig: Rig) -> dict[str, Any]:
    """Return an effect with the angle of an end stop as the joint's, where it is drawn from where the limb hangs.

    A stop's side is the sign of its angle: where a limb hangs so far off that this would be the wrong one, the stop is
    on the limb's other side.
    """
    if effect["effect"] != "end_stop" or rig.tree.hinge is None:
        return effect
    p, rest = effect["parameters"], hanging(rig)
    away = p["angle"] if (rest + p["angle"]) * p["angle"] > 0 else -p["angle"]
    return effect | {"parameters": p | {"angle": float(rest + away)}}


def _instruments(
    spec: Spec, rng: np.random.Generator, family: str
) -> tuple[DrawnEncoder | None, tuple[DrawnPose, ...]]:
    first, *others = rng.spawn(1 + len(spec.poses))
    encoder = spec.encoder.draw(first, family) if spec.encoder is not None else None
    poses = (pose.draw(own, rig_tree(family).names) for pose, own in zip(spec.poses, others, strict=True))
    return encoder, tuple(pose for pose in poses if pose is not None)


def _parts(spec: Spec, rng: np.random.Generator, sensors: list[str]) -> dict[str, ImuProfile]:
    """Return two parts of one profile."""
    profile = spec.imus[pick([imu.weight for imu in spec.imus], rng)].profile
    return {at: bought(profile, spec.rate, stream) for at, stream in zip(sensors, rng.spawn(len(sensors)), strict=True)}


def _measured(spec: Spec, mount: Mount, rng: np.random.Generator) -> DeclaredMount:
    """Return a mount's pose as its owner measured it, off by the stds that he declares."""
    std = spec.declared.position_std, spec.declared.rotation_std
    position = mount.position + std[0] * rng.standard_normal(3)
    turned = rotations.multiply(mount.quaternion, rotations.exp(std[1] * rng.standard_normal(3)))
    return DeclaredMount(position, turned, *std)

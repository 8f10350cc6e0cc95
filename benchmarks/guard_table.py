"""When Algorithm 4 and the guarded estimator accept, and how often they should not: python -m benchmarks.guard_table.

Prints the operating table of docs/plug-and-play.md. Rigs are drawn at random; none was looked at to set the guard.
"""

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from benchmarks.table import Row
from imubench import rotations
from imubench.arrays import Array
from imubench.estimators.guarded import Guard, GuardedPlugAndPlay
from imubench.estimators.plug_and_play import PlugAndPlay, Settings, Update, at_rate, batches
from imubench.paired import Paired, paired
from imubench.recording import Recording
from imubench.scenarios.olsson2020.motions import MOTIONS, paper_rig
from imubench.scenarios.olsson2020.plan import find
from imubench.scenarios.olsson2020.sequences import Sequence, add_bias, join
from imubench.scenarios.olsson2020.session import SNAP, Session, record
from imubench.score import axis_deviation
from imubench.sim.profiles import profile
from imubench.sim.rigs import Mount, Rig, random_hinge, springs

SHORT = dict.fromkeys(MOTIONS, 20.0)  # s; sequences 3 and 4 need 20 s of motion 6
E_MAX = Settings().e_max
SEEDS = 6  # sessions a group, four sequences each
SEVERE = 0.35  # rad; mounts that sag more under gravity are not drawn


@dataclass(frozen=True)
class Case:
    """A recording and where the hinge really lay in the sensors' axes."""

    recording: Recording
    time: Array  # (n,) s
    axes: Array  # (n, 2, 3) the mean from the start to each time: foam sags, and the axis goes along

    def error(self, estimate: Array, until: float) -> float:
        """Return by how much an estimate (2, 3) made `until` s is off, in rad, the worse of both axes."""
        row = np.searchsorted(self.time, until, side="right") - 1
        return float(axis_deviation(estimate, self.axes[row]).max())


@dataclass(frozen=True)
class Outcome:
    """What one stream did over one recording."""

    accepted: bool
    error: float  # rad, of the first accepted estimate, larger of the two axes
    seconds: float  # until then
    worst_later: float  # rad, of all accepted estimates


def soft_rig(rng: np.random.Generator, which: tuple[int, ...] = (0, 1)) -> Rig:
    """Return the paper's rig with IMUs that rock on foam of 2 to 20 Hz, damped by 0.05 to 1."""
    mounts = []
    for i, mount in enumerate(paper_rig().mounts):
        if i not in which:
            mounts.append(mount)
            continue
        frequency, damping = 2.0 * 10.0 ** rng.uniform(size=3), 0.05 * 20.0 ** rng.uniform()
        com = rng.normal(scale=0.003, size=3)
        sag = 9.81 * np.linalg.norm(com) / mount.gyration**2 / (2 * np.pi * frequency.min()) ** 2
        com *= min(1.0, SEVERE / sag)
        lever = np.array([0.0, 0.0, rng.uniform(0.0, 0.02)])
        mounts.append(
            Mount(mount.position, rotations.random(rng), rotation=springs(frequency, damping), com=com, lever=lever)
        )
    return paper_rig(mounts=tuple(mounts))


def sequences(
    seeds: range,
    rig: Callable[[np.random.Generator], Rig] | None = None,
    names: tuple[str, ...] = ("sequence1", "sequence2", "sequence3", "sequence4"),
    imus: str = "xsens_mtw",
    offset: float = 0.0,
    remove: bool = True,
    added: tuple[float, float] | None = None,
) -> Iterator[Case]:
    """Play the paper's sequences, all of one session, with 20 s a motion; `offset` in s is imu2's clock's."""
    for seed in seeds:
        rng = np.random.default_rng([8, seed])
        part = profile(imus)
        late = replace(part, clock_offset=offset * rng.choice([-1.0, 1.0]))
        session = record(seed, rig and rig(rng), {"imu1": part, "imu2": late}, remove, SHORT)
        for name in names:
            sequence = join(find(name), session)
            recording = sequence.recording
            yield case(session, sequence, add_bias(recording, rng, *added) if added else recording)


def case(session: Session, sequence: Sequence, recording: Recording) -> Case:
    truth, times, rows = session.truth, [], []
    for section in sequence.sections:
        first = session.span(section.motion)[0] + section.cut_start
        begin, end = np.searchsorted(truth.time, [first - SNAP, first + section.end - section.start - SNAP])
        times.append(truth.time[begin:end] - first + section.start)
        rows.append(np.stack([s.joint_axis[begin:end] for s in truth.sensors if s.joint_axis is not None], axis=1))
    means = np.cumsum(np.concatenate(rows), axis=0)
    return Case(recording, np.concatenate(times), means / np.linalg.norm(means, axis=-1, keepdims=True))


def judge(one: Case, stream: Callable[[Paired], Update], samples: Paired) -> Outcome:
    errors, first = [], float("nan")
    for batch in batches(samples):
        update = stream(batch)
        if update.accepted:
            errors.append(one.error(update.estimate.value, float(batch.time[-1])))
            first = first if len(errors) > 1 else float(batch.time[-1] - samples.time[0])
    return Outcome(bool(errors), errors[0] if errors else float("nan"), first, max(errors, default=float("nan")))


def both(one: Case, seed: int, guard: Guard) -> tuple[Outcome, Outcome]:
    samples = paired(one.recording)
    settings = at_rate(samples)
    plain = PlugAndPlay(settings, np.random.default_rng(seed))
    careful = GuardedPlugAndPlay(settings, np.random.default_rng(seed), guard)
    return judge(one, plain.update, samples), judge(one, careful.update, samples)


def cells(side: list[Outcome]) -> str:
    """Return accepted, of which wrong, seconds to the first, worst error of a first one, recordings with any wrong."""
    accepted = [o for o in side if o.accepted]
    wrong = sum(o.error > E_MAX for o in accepted)
    ever = sum(o.worst_later > E_MAX for o in accepted)
    seconds = f"{np.median([o.seconds for o in accepted]):.0f}" if accepted else "-"
    worst = f"{np.degrees(max(o.error for o in accepted)):.1f}" if accepted else "-"
    return f"{len(accepted)} | {wrong} | {ever} | {seconds} | {worst}"


TOLD = "the same, and the guard told so"
GROUPS: dict[str, Callable[[int], Iterator[Case]]] = {
    "rigid, MTw, gyro bias removed, sequences 1 to 4": lambda n: sequences(range(n)),
    "rigid, MTw, gyro bias left in": lambda n: sequences(range(100, 100 + n), remove=False),
    "rigid, random rigs and lever arms up to 25 cm": lambda n: sequences(range(200, 200 + n), random_hinge),
    "rigid, MTw, bias of 1 deg/s and 1 m/s^2 added": lambda n: sequences(
        range(300, 300 + n), added=(np.deg2rad(1.0), 1.0)
    ),
    TOLD: lambda n: sequences(range(300, 300 + n), added=(np.deg2rad(1.0), 1.0)),
    "rigid, clocks 20 ms apart": lambda n: sequences(range(400, 400 + n), offset=0.02),
    "rigid, clocks 100 ms apart": lambda n: sequences(range(500, 500 + n), offset=0.1),
    "one IMU on foam, 2 to 20 Hz": lambda n: sequences(range(600, 600 + n), partial(soft_rig, which=(1,))),
    "both IMUs on foam, 2 to 20 Hz": lambda n: sequences(range(700, 700 + n), soft_rig),
}


def outcomes(seeds: int, name: str) -> tuple[list[Outcome], list[Outcome]]:
    """Return what Algorithm 4 and the guarded estimator did over a group of recordings."""
    guard = Guard(np.deg2rad(1.0) / np.sqrt(3), 1.0 / np.sqrt(3)) if name == TOLD else Guard()
    pairs = [both(one, i, guard) for i, one in enumerate(GROUPS[name](seeds))]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def run() -> list[Row]:
    """Return a row for each group: how many recordings had an accepted estimate, and how many ever a wrong one."""
    rows = []
    for name in GROUPS:
        plain, careful = outcomes(SEEDS, name)
        wrong = [sum(o.worst_later > E_MAX for o in side) for side in (careful, plain)]
        cells = (f"{sum(o.accepted for o in s)} of {len(s)}, {w}" for s, w in zip((careful, plain), wrong, strict=True))
        what = f"recordings with an accepted estimate, and with a wrong one, guarded beside Algorithm 4: {name}"
        rows.append(Row(what, *cells, "-", "none wrong", wrong[0] == 0))
    return rows


def main(seeds: int, groups: list[str]) -> None:
    """Print the table, or its lines for groups that contain one of `groups`."""
    head = "accepted | wrong | ever wrong | s | worst, deg"
    print(f"| | runs | {head} | {head} |")
    print("|---|---:|" + "---:|" * 10)
    for name in GROUPS:
        if groups and not any(g in name for g in groups):
            continue
        plain, careful = outcomes(seeds, name)
        print(f"| {name} | {len(plain)} | {cells(plain)} | {cells(careful)} |", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else SEEDS, sys.argv[2:])

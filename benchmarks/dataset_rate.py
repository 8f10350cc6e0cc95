"""How fast a dataset's recordings are made, Parquet included, beside bare MuJoCo stepping of their models and imt-ring.

Processor time of one core counts, so that other work on the machine does not.
"""

import io
import re
import time
from dataclasses import dataclass
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from mujoco import batch as mujoco_batch
from threadpoolctl import threadpool_limits

from benchmarks.simulation_rate import RING_CHAIN
from benchmarks.table import Row
from imubench.dataset import columns, make, parse_spec
from imubench.dataset.shard import PARQUET
from imubench.sim.compile import compile_model
from imubench.sim.sprung import stepping_model

HINGE = "[[rig]]\nfamily = 'hinge'\n"
RIGID = {
    "rigid mounts": HINGE,
    'rigid mounts, truth = "core"': "truth = 'core'\n" + HINGE,
    "rigid mounts, mpu9250 (truth ten times as dense)": HINGE + "[[imu]]\nprofile = 'mpu9250'",
}
SPRUNG = {
    "both IMUs on rocking springs of 5 to 25 Hz": HINGE + "rocking_probability = 1",
    "both IMUs on sliding springs of 5 to 25 Hz": HINGE + "soft_probability = 1",
    "both IMUs on rocking springs of 10 Hz": HINGE + "rocking = { frequency = 10 }",
}
SECONDS, RATE = 60, 100


@dataclass
class Spent:
    """Processor seconds and what they were spent on."""

    ours: float = 0.0
    bare: float = 0.0
    steps: int = 0
    size: int = 0  # bytes


@threadpool_limits.wrap(limits=1)  # as `generate` has it: threads that wait for each other are no work
def spend(text: str, count: int) -> Spent:
    """Make and encode `count` recordings, and step the models of those with springs as often, nothing recorded."""
    spec, spent = parse_spec({"spec.toml": text.encode()}), Spent()
    floats = [f.name for f in columns.schema(spec) if pa.types.is_floating(f.type)]
    columns.samples_table(spec, make(spec, 1, count))  # imports and caches
    for index in range(count):
        start = time.process_time()
        made, file = make(spec, 1, index), io.BytesIO()
        table = columns.samples_table(spec, made)
        pq.write_table(table, file, use_byte_stream_split=floats, **PARQUET)
        spent.ours += time.process_time() - start
        spent.size += file.tell()
        rig = made.drawn.rig
        if rig.sprung:
            model = stepping_model(compile_model(rig, driven="joints"), RATE)
            steps = round(SECONDS / model.opt.timestep)
            batch = mujoco_batch.Batch(model, nsim=1, nthread=1)
            start = time.process_time()
            batch.rollout(steps, record=())
            spent.bare += time.process_time() - start
            spent.steps += steps
    return spent


def ring_rate(calls: int = 8) -> float:
    """Return samples per CPU s of imt-ring's hinge chain with both IMUs on springs, as called, nothing stored.

    Its springs need masses of the IMUs and damped joints.
    """
    import ring

    imu = r"\1><geom type='box' mass='0.02' dim='0.05 0.03 0.02'/></body>"
    chain = re.sub(r'(<body name="imu\d" [^>]*)/>', imu, RING_CHAIN)
    chain = chain.replace('joint="free"', 'joint="free" damping="5 5 5 25 25 25"')
    chain = chain.replace('joint="ry"', 'joint="ry" damping="3"')

    def generator() -> Any:
        system, config = ring.System.create(chain), ring.MotionConfig(T=float(SECONDS))
        wanted = {"add_X_imus": True, "add_y_relpose": True, "disable_tqdm": True}
        return ring.RCMG(system, config, dynamic_simulation=True, imu_motion_artifacts=True, **wanted)

    generator().to_list(1)  # imports and caches
    start = time.process_time()
    generator().to_list(calls)
    return calls * SECONDS * RATE / (time.process_time() - start)


def beside_ring(what: str, rate: float) -> Row:
    """Return the row of a rate, in samples per CPU s, beside imt-ring's."""
    theirs = ring_rate()
    called = (
        "imt-ring 1.7.1, dynamic_simulation and imu_motion_artifacts: RCMG.to_list(8) of 60 s, compilation included"
    )
    what = f"dataset, hinge, {what}: samples per CPU s with truth in Parquet, against {called}"
    return Row(what, f"{rate:,.0f}", f"{theirs:,.0f}", f"{rate / theirs:.1f}", ">= 50", rate >= 50 * theirs)


def run() -> list[Row]:
    """Return all rows."""
    rows, sprung = [], {}
    for what, text in (RIGID | SPRUNG).items():
        count = 20 if what in RIGID else 32  # of 8 the share differs by 0.04 from run to run beside other work
        spent = spend(text, count)
        rate = f"{count * SECONDS / spent.ours:,.0f} s/s, {count * SECONDS * RATE / spent.ours:,.0f} samples/s"
        size = f"{spent.size / 1e6 / count * 3600 / SECONDS:.0f} MB/h"
        if what in SPRUNG:
            sprung[what] = count * SECONDS * RATE / spent.ours
        what = f"dataset, hinge, two IMUs, 60 s at 100 Hz with truth in Parquet, {size}; {what}: recorded s per CPU s"
        if not spent.bare:
            rows.append(Row(what, rate, "-", "-", "-", True))
            continue
        ratio = spent.bare / spent.ours
        bare = f"{spent.steps / spent.bare:,.0f} steps/s"
        rows.append(Row(what + ", beside bare mujoco.batch", rate, bare, f"{ratio:.2f}", ">= 0.70", ratio >= 0.7))
    return [*rows, *(beside_ring(what, sprung[what]) for what in list(SPRUNG)[:1])]

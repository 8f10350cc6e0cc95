"""How fast rigs are simulated, beside bare MuJoCo stepping and beside imt-ring's generator."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from mujoco import batch as mujoco_batch

from benchmarks.table import Row
from imubench.scenarios.hinge import hand_motion
from imubench.sim.play import play
from imubench.sim.rigs import random_hinge
from imubench.sim.swing import BLOCK, Start, _compile, _initial_state, swing_many

RIGS, SECONDS, RATE = 1000, 10.0, 1000.0


def seconds(job: Callable[[], object]) -> float:
    """Return how long a job takes."""
    start = time.perf_counter()
    job()
    return time.perf_counter() - start


def swings() -> Row:
    """Simulate 1,000 random hinge rigs, 10 s at 1 kHz, with their truth; bare stepping of the same models in turn."""
    rng = np.random.default_rng(0)
    rigs = [random_hinge(rng, base="fixed") for _ in range(RIGS)]
    starts = [Start(angle=float(rng.uniform(-1.5, 1.5))) for _ in rigs]
    steps = round(SECONDS * RATE)
    bare = ours = 0.0
    for first in range(0, RIGS, 100):  # in turn, so that both meet the same machine
        part = slice(first, first + 100)
        models = [_compile(rig, 1 / RATE) for rig in rigs[part]]
        batch = mujoco_batch.Batch(models[0], nsim=len(models))
        batch.set_models(models)
        for i, start in enumerate(starts[part]):
            batch.bind("qpos")[i], batch.bind("qvel")[i] = _initial_state(models[i], rigs[0].tree, start)
        bare += seconds(lambda b=batch: b.rollout(steps, record=()))
        ours += seconds(lambda p=part: [t.joint_angle[-1] for t in swing_many(rigs[p], starts[p], SECONDS, RATE)])
    rates = RIGS * steps / ours, RIGS * steps / bare
    ratio = rates[0] / rates[1]
    what = f"{RIGS} random hinge rigs, {SECONDS:g} s at 1 kHz, blocks of {BLOCK}: steps/s against bare mujoco.batch"
    return Row(what, f"{rates[0]:,.0f}", f"{rates[1]:,.0f}", f"{ratio:.2f}", ">= 0.80", ratio >= 0.8)


def prescribed() -> list[Row]:
    """Play random prescribed motion at 100 Hz with its truth, beside imt-ring's random chains."""
    as_called, compiled = ring_rates()
    rng = np.random.default_rng(0)
    samples, spent = 0, 0.0
    for _ in range(20):
        rig = random_hinge(rng)
        spent += seconds(lambda r=rig: play(r, hand_motion(rng, 600.0), 600.0, 100.0))
        samples += 60_000
    rate = samples / spent
    what = "prescribed motion of a hinge rig, two IMUs, motion drawn, truth complete, samples/s, against imt-ring 1.7.1"
    called = f"{what}: RCMG.to_list(8) of 60 s, as its guide calls it, compilation included"
    warm = f"{what}: its compiled generator, batch of 32, compilation left out"
    return [
        Row(called, f"{rate:,.0f}", f"{as_called:,.0f}", f"{rate / as_called:.0f}", ">= 100", rate >= 100 * as_called),
        Row(warm, f"{rate:,.0f}", f"{compiled:,.0f}", f"{rate / compiled:.2f}", "none", True),
    ]


def ring_rates() -> tuple[float, float]:
    """Return samples/s of imt-ring's two-segment hinge chain with IMUs: as called, and compiled beforehand."""
    import jax
    import ring

    def chain() -> Any:
        system = ring.System.create(RING_CHAIN)
        config = ring.MotionConfig(T=60.0)
        return ring.RCMG(system, config, add_X_imus=True, add_y_relpose=True, disable_tqdm=True)

    chain().to_list(1)  # imports and caches
    called = 8 * 6000 / seconds(lambda: chain().to_list(8))
    draw = chain().to_lazy_gen(sizes=32)
    jax.block_until_ready(draw(jax.random.PRNGKey(0)))
    spent = min(seconds(lambda k=k: jax.block_until_ready(draw(jax.random.PRNGKey(k)))) for k in range(1, 4))
    return called, 32 * 6000 / spent


RING_CHAIN = """
<x_xy model="hinge">
  <options gravity="0 0 9.81" dt="0.01"/>
  <worldbody>
    <body name="seg1" joint="free">
      <geom type="box" mass="0.25" pos="-0.1 0 0" dim="0.2 0.04 0.04"/>
      <body name="imu1" joint="frozen" pos="-0.1 0 0.03"/>
      <body name="seg2" joint="ry">
        <geom type="box" mass="0.25" pos="0.1 0 0" dim="0.2 0.04 0.04"/>
        <body name="imu2" joint="frozen" pos="0.1 0 0.03"/>
      </body>
    </body>
  </worldbody>
</x_xy>
"""


def run() -> list[Row]:
    """Return all rows."""
    return [swings(), *prescribed()]

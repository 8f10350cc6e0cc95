"""Laws as rows: what effects' states obey between the knots, and the equation of motion inside free swings."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from imubench.chain_rule import carrier, chained
from imubench.diagnosis.problem.batch_model import Model, inside
from imubench.diagnosis.problem.bspline import Moment
from imubench.diagnosis.problem.hypothesis import Hypothesis, State
from imubench.diagnosis.problem.residuals import Rows
from imubench.effects.effect import Scene
from imubench.jets import Jet


def state_rows(model: Model, state: State, only: Hypothesis | None = None) -> Iterator[Rows]:
    """Yield what the states of every effect, or of one, obey; one row an interval that has samples."""
    for h, scene in scenes(model, state, only):
        yield from law_rows(model, state, h, scene)


def law_rows(model: Model, state: State, h: Hypothesis, scene: Scene) -> Iterator[Rows]:
    """Yield what the states of an effect obey, with a scene that is known already."""
    for rows in laws_on_segment(model, state, h, scene):
        yield replace(rows, residual=chained(rows.residual, scene.segment))


def laws_on_segment(model: Model, state: State, h: Hypothesis, scene: Scene) -> Iterator[Rows]:
    """Yield the same, derivatives by the motion of the segment not yet taken on to the splines."""
    for law in h.effect.equations(scene, model.values(h, state)):
        std = np.full(law.residual.value.shape[1], law.std)
        yield Rows(h.key(law.name), inside(model), law.residual, std, counts=False)


def scenes(model: Model, state: State, only: Hypothesis | None = None) -> Iterator[tuple[Hypothesis, Scene]]:
    """Yield every effect with states, or one, and what it may ask of the rig, where its law is asked.

    The segment moves in variables of its own (`imubench/chain_rule.py`), which `law_rows` takes on to the splines.
    """
    hypotheses = [h for h in model.hypotheses if h.effect.states and only in (None, h)]
    if not hypotheses:
        return
    moment = Moment(model.tracks, state.coefficients, Jet(inside(model)[:, None]))
    segments = model.segments(state, moment)
    for h in hypotheses:
        imu = next((i for i in model.recording.imus if i.name == h.at), None)
        segment = carrier(segments[model.rig.tree.carriers.get(h.at, model.rig.tree.names[0])])
        scene = model.own(model.scene(moment, segment), h, moment)
        if imu is not None:
            link = model.mount(imu, state, moment, segment)
            scene = replace(scene, mount=link, sensor=segment.child(link))
        yield h, scene

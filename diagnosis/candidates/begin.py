"""How a diagnosis begins: the raw samples checked, and the motion fitted to what is left of them."""

from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from imubench.diagnosis.budget import Budget
from imubench.diagnosis.candidates.end_stop import settled_between, stop_of
from imubench.diagnosis.candidates.end_stop_contacts import contact_stop
from imubench.diagnosis.candidates.giving_way import with_what_gives_way
from imubench.diagnosis.config.candidates import END_STOP
from imubench.diagnosis.config.solve import SOLVER
from imubench.diagnosis.config.verdict import BUDGET
from imubench.diagnosis.noise.decimation import Decimated, decimated
from imubench.diagnosis.noise.knot_selection import coarsest
from imubench.diagnosis.noise.nominal import first_fit, nominal_fit
from imubench.diagnosis.problem.fit import Fit
from imubench.diagnosis.samples.screening import SampleChecks, check_samples
from imubench.diagnosis.sensor_errors.baseline import Learned
from imubench.diagnosis.sensor_errors.sampling_age import of_one_age
from imubench.diagnosis.solve.initialize import model_of
from imubench.diagnosis.windows import Window
from imubench.effects import EFFECTS
from imubench.progress import Step, silent
from imubench.recording import Recording

FITTING_THE_MOTION = "the fit of the motion to its end"


@dataclass(frozen=True)
class Beginning:
    """A recording's samples and the motion without any effect."""

    samples: SampleChecks
    first: Fit  # of the model as it was declared
    fit: Fit  # where no end stop knocks, on as few knots as it needs; the search for effects goes on from here
    finished: bool = True  # False: the time limit came first, and `first` is two steps from where the fit begins


def begin(
    recording: Recording,
    step: Step = silent,
    budget: Budget | None = None,
    learned: Learned | None = None,
    every_sample: bool = False,
) -> Beginning:
    """Return what a recording shows before anything is looked for, beside what is `learned` of its sensors.

    With `every_sample` the fit sees the recording's own, even where fewer would tell the motion.
    """
    budget = budget or Budget()
    with step("check the samples"):
        samples = check_samples(recording)
        samples = samples if learned is None else learned.on(samples)
    sensors = () if learned is None else learned.hypotheses
    first = fit = None
    with step("fit the motion to every sample" if every_sample else "fit the motion"):
        known, aged = of_one_age(samples.heard(recording), samples.masks)
        fewer = Decimated(known) if every_sample else decimated(known, samples)
        known, samples = fewer.recording, replace(samples, notes=(*samples.notes, *aged, *fewer.notes))

        def fitted(swings: tuple[Window, ...], masks: dict[str, NDArray[np.bool_]]) -> Fit:
            seen = replace(known, free_swings=swings)
            return nominal_fit(seen, masks, samples.humming, samples.wander, sensors, fewer.averaging)

        with budget.part(BUDGET.fit, FITTING_THE_MOTION):
            fit = first = fitted(known.free_swings, samples.masks)
            heard = partial(stop_of, first, samples)
            met = partial(contact_stop, first, known.free_swings, lambda swings: fitted(swings, samples.masks))
            ways = (met, heard) if fit.model.rig.ball else (heard, met)  # a push tells its axis, knocks do not
            if EFFECTS.first(lambda e: e.stops_at) and (stop := ways[0]() or ways[1]()):
                without = fitted(stop.swings(known.free_swings), stop.masks(first, samples.masks))
                stop = settled_between(stop, without)
                if stop.std < END_STOP.unsettled_rad:
                    fit, samples = without, stop.told(samples)
            fit = with_what_gives_way(fit) or coarsest(fit)
        if first is None or fit is None:
            rough = first_fit(model_of(known, averaging=fewer.averaging), SOLVER.few_steps)
            return Beginning(samples, rough, rough, finished=False)
    return Beginning(samples, first, fit)

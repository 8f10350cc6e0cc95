"""What a diagnosis says, in one sentence, and how far the simulations are from the recording."""

from dataclasses import dataclass

import numpy as np

from imubench.diagnosis.config.report import PAGE
from imubench.diagnosis.config.shared import CONFIDENCE, DECLARED_NOISE
from imubench.diagnosis.report import words
from imubench.diagnosis.report.numbers import brief, printed, shown
from imubench.diagnosis.result import Diagnosis, Simulation
from imubench.sim.profiles import PROFILES


@dataclass(frozen=True)
class Deviation:
    """How far the simulation is from one channel, in the laboratory's unit."""

    channel: str
    before: str
    after: str
    noise: str
    unit: str
    times_before: float  # the noise
    times_after: float


def deviations(s: Simulation) -> list[Deviation]:
    """Return how far each channel is off, the farthest over its noise as declared first."""
    found = []
    for name, c in s.channels.items():
        factor, unit = printed(c.unit)
        noise = max(c.noise, 1e-300)
        before, after, level = (brief(factor * v) for v in (c.before, c.after, c.noise))
        found.append(Deviation(name, before, after, level, unit, c.before / noise, c.after / noise))
    return sorted(found, key=lambda off: -off.times_before)


def times_noise(s: Simulation) -> tuple[float, float]:
    """Return the RMS over all channels of how far both models are off, over the noise."""
    every = deviations(s)
    before, after = (np.array([getattr(o, key) for o in every]) for key in ("times_before", "times_after"))
    return float(np.sqrt(np.mean(before**2))), float(np.sqrt(np.mean(after**2)))


def shown_by(s: Simulation | None) -> bool:
    """Return whether MuJoCo's simulations show that something was found: the declared one is off, and farther off.

    Where a motion is prescribed, the one that was recovered under the declared model may follow the sensors as well.
    """
    if s is None or not s.channels:
        return False
    before, after = times_noise(s)
    return before > DECLARED_NOISE.most_std and before > after


def explained_percent(d: Diagnosis) -> str:
    """Return which share of the power of what differs the findings explain, in words; empty where nothing tells.

    Of MuJoCo's simulations where they were played; else of the fitted motion's residuals beyond noise.
    """
    before, after = d.misfit
    if d.simulation is not None and shown_by(d.simulation):
        before, after = (x**2 for x in times_noise(d.simulation))
    elif before <= DECLARED_NOISE.most_std:
        return ""
    share = float(np.clip(1 - after / before, 0, 1)) if before > 0 else 0.0
    return words.percent(np.floor(100 * share) / 100)  # 99.7 % explained is not 100 %


def headline(d: Diagnosis) -> str:
    """Return the verdict in a few sentences for somebody who has seen nothing else; what makes no sense comes first."""
    odd = "; ".join(n.what for n in d.nonsense)
    odd = odd if odd.startswith(("imu", "pose", "gyr", "acc")) else odd[:1].upper() + odd[1:]  # names stay names
    if not d.fitted:
        return f"{odd}. No simulation can be held against that."
    return f"{_headline(d)} {odd}." if odd else _headline(d)


def _headline(d: Diagnosis) -> str:
    sure = [f for f in d.findings if f.named and f.confidence >= CONFIDENCE.counts]
    matters = [f for f in sure if f.material] or sure
    named = words.listed([words.called(f.effect, f.at) for f in matters])
    if d.verdict == "unobservable":
        return f"This recording cannot show {words.listed([u.what for u in d.unseen])}."
    if d.verdict == "no mismatch":
        return _agrees(d)
    if d.verdict == "unexplained":
        where = d.where[0] if d.where else None
        place = "" if where is None else f", most of all at {where.at} ({words.channels(where)})"
        why = (
            "what explains it was not found in the time given" if d.stopped else "no effect of the library explains it"
        )
        return f"The simulation and this recording differ{place}, and {why}. {_off(d, with_it=False)}".strip()
    small = "" if any(f.material for f in matters) else f", which moves nothing by {words.tolerance(d)}"
    text = f"The simulation leaves out {named}{small}."
    if d.doubts:
        return f"{text[:-1]}, or something like it; no model was found that can be trusted. {_off(d)}".strip()
    return f"{text} {_off(d)} {_left(d)}".replace("  ", " ").strip()


def _agrees(d: Diagnosis) -> str:
    if d.noise_unknown:
        return (
            "Nothing was found that the simulation leaves out. How loud the sensors are is not known, so what is as "
            "quiet as their noise may still be there."
        )
    if d.simulation is not None and d.simulation.channels and times_noise(d.simulation)[1] > DECLARED_NOISE.most_std:
        return f"No effect was found that the simulation leaves out. {_off(d, with_it=False)}"
    return "The simulation and this recording agree: what differs is sensor noise."


def _off(d: Diagnosis, with_it: bool = True) -> str:
    """Return how far the simulations are off in the channel that differs most over its noise; empty if not played."""
    if d.simulation is None or not d.simulation.channels or (with_it and not shown_by(d.simulation)):
        return ""
    worst = deviations(d.simulation)[0]
    at = words.spelled(worst.channel)
    if not with_it:
        return f"MuJoCo's simulation is off by {worst.before} {worst.unit} RMS at the {at}."
    return (
        f"As declared, MuJoCo's simulation is off by {worst.before} {worst.unit} RMS at the {at}; "
        f"with that in it, by {worst.after} {worst.unit}."
    )


def _left(d: Diagnosis) -> str:
    """Return what is left with the findings in the model."""
    share = explained_percent(d)
    if d.noise_unknown:
        told = f"That explains {share} of what differs. " if share else ""
        sensors = words.listed(list(d.noise_unknown))
        return f"{told}Whether only noise is left cannot be said: the noise of {sensors} is not known."
    if d.verdict == "explained":
        if d.simulation is None or not d.simulation.channels or times_noise(d.simulation)[1] <= DECLARED_NOISE.most_std:
            return "With that in it, only sensor noise is left."
        return f"That explains {share} of what differs." if share else ""
    return f"That explains {share} of what differs; the rest is unexplained." if share else "The rest is unexplained."


def usual_noise(d: Diagnosis, rates: dict[str, float]) -> str:
    """Return how loud IMUs usually are, beside what was taken for noise; empty where each noise is known.

    Args:
        d: the diagnosis.
        rates: Hz, by IMU.
    """
    said: dict[str, list[str]] = {}
    for name in d.noise_unknown:
        at, _, part = name.partition(".")
        if at not in rates:
            continue
        found = sorted(
            std for p in PROFILES.values() if (std := getattr(p, part).declared_noise_std(rates[at])) > PAGE.ideal_noise
        )
        level = d.noise[name]
        factor, unit = printed(level.unit)
        low, high, taken = (brief(factor * x) for x in (found[0], found[-1], level.std))
        usual = low if low == high else f"{low} to {high}"
        text = f"taken to have {taken} {unit} per sample, such IMUs usually have {usual}"
        said.setdefault(text, []).append(name)
    parts = [f"{words.listed(names)} {'was' if len(names) == 1 else 'were'} {text}" for text, names in said.items()]
    return f"{'; '.join(parts)}." if parts else ""


def against_reference(d: Diagnosis) -> list[tuple[str, float, float]]:
    """Return what is measured against the reference, and how far it is off in deg RMS, as declared and as found."""
    base, _, _ = d.fit.reference.unit.partition(" ")
    change = d.fit.reference
    return [
        (words.MEASURED_WORDS.get(name, name), shown(was, base)[0], shown(change.after[name], base)[0])
        for name, was in change.before.items()
    ]


def places(d: Diagnosis, span: tuple[float, float], zero: float | None = None) -> list[str]:
    """Return sentences about where the recording differs from the declared model; `span`, `zero`: as `location`."""
    if not d.fitted:
        return list(dict.fromkeys(f"To do: {n.advice}." for n in d.nonsense))
    if d.where:
        return [words.location(w, span, zero) for w in d.where]
    if d.simulation is not None and d.simulation.channels and times_noise(d.simulation)[0] > DECLARED_NOISE.most_std:
        worst = deviations(d.simulation)[:3]
        told = [
            f"the {words.spelled(o.channel)} ({o.before} {o.unit} RMS)"
            for o in worst
            if o.times_before > DECLARED_NOISE.most_std
        ]
        return [f"At {words.listed(told)}."]
    if d.noise_unknown:
        return ["Nowhere by more than what was taken for noise."]
    return ["Nowhere by more than the sensors' noise."]


__all__ = [
    "Deviation",
    "against_reference",
    "deviations",
    "explained_percent",
    "headline",
    "places",
    "shown_by",
    "times_noise",
    "usual_noise",
]

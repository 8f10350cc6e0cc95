"""What a recording cannot tell apart: effects that, in another's place, would explain it as well.

What an effect adds to the measurements is held against what a rival can make of them once the motion, the
geometry and the other effects have followed. With M the information of both after that, a the effect's own
column (its mark, as fitted), r the rival's parameters and L its prior's information, the rival would cost
the fit (M_aa - M_ar (M_rr + L)^-1 M_ra) / 2 nat.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from imubench.arrays import Array
from imubench.diagnosis.blocks import NotPositiveDefiniteError, solve_arrow
from imubench.diagnosis.fit import Fit, all_rows
from imubench.diagnosis.model import Hypothesis, Model, State
from imubench.diagnosis.refit import extended, guess_of, log_evidence, refit
from imubench.diagnosis.rows import Normal, Parameters, Rows, linearise
from imubench.diagnosis.terms import interpolated
from imubench.diagnosis.threads import one_thread
from imubench.effects import EFFECTS, VARIANTS, possible
from imubench.jets import CONSTANT, Jet
from imubench.recording import Imu

LIKE = 5.0  # nat, up to which a rival counts as equal: odds of 150
DOUBT = 0.2  # of what an effect explains: a rival that would lose less is refitted, for laws are not linear
REFITTED = 3  # rivals at most
CLOCKS = ("time_offset", "clock_skew")
MARK = "mark"
NEAR = 1.12  # how far apart the cutoffs are that are tried
FINE = 0.3  # of a delay: the steps at which a filter that stands for it is computed

Columns = dict[str, dict[str, Array]]
"""What something adds to the model's readings (n, m), by its name and by group of measurements."""


@dataclass(frozen=True)
class Rival:
    """An effect that could stand in another's place."""

    effect: str
    at: str
    loss: float  # nat, what the fit would lose
    exact: bool = False  # refitted, not only expected


@dataclass(frozen=True)
class Joint:
    """Hypotheses and columns after motion, geometry and every other effect have followed them."""

    places: dict[str, NDArray[np.int64]]  # of each hypothesis' parameters, and of each column
    information: Array  # (k, k)
    gradient: Array  # (k,)
    prior: Array  # (k,) standard deviations, infinite for columns

    def explained(self, wanted: Array, by: Array) -> tuple[float, Array]:
        """Return what is lost when directions (k, m) stand for a direction (k,), and their sizes (m,)."""
        weight = np.where(np.isfinite(self.prior), 1 / self.prior, 0.0)
        unit = by / np.maximum(np.sqrt(np.sum((weight[:, None] * by) ** 2, axis=0)), 1e-300)  # a prior's std each
        inner = unit.T @ self.information @ unit + (weight[:, None] * unit).T @ (weight[:, None] * unit)
        pull = unit.T @ self.information @ wanted
        size = np.linalg.solve(inner, pull)
        loss = 0.5 * float(wanted @ self.information @ wanted - pull @ size)
        return max(loss, 0.0), size * np.linalg.norm(unit, axis=0) / np.maximum(np.linalg.norm(by, axis=0), 1e-300)

    def along(self, *names: str) -> Array:
        """Return the directions (k, m) of the parameters or columns of these names."""
        return np.eye(len(self.prior))[:, np.concatenate([self.places[n] for n in names])]


@one_thread
def joint(model: Model, state: State, fit: Fit, fresh: Sequence[Hypothesis], columns: Columns | None = None) -> Joint:
    """Return the information of hypotheses in `model`, and of columns, at a state, with a fit's noise."""
    extra = columns or {}
    own = {h.key(p.name) for h in fresh for p in h.effect.parameters}
    widths = model.parameters.widths | dict.fromkeys(extra, 1)
    parameters = Parameters(widths)
    rows = all_rows(model, state, fit.noise, fit.anchor, fit.loose)
    kept = [_marked(r, extra) for r in rows if r.name not in {f"prior.{n}" for n in own}]
    normal = Normal.empty(model.tracks, parameters)
    normal.add([linearise(r, model.tracks, parameters) for r in kept])
    normal.fill(model.tracks)
    solution = solve_arrow(normal.band, normal.border, normal.corner)
    names = [h.key(p.name) for h in fresh for p in h.effect.parameters] + list(extra)
    information, gradient = solution.reduced(normal.gradient, normal.corner_gradient, parameters.places(names))
    prior = [model.priors[n].std for n in names if n in own] + [np.full(len(extra), np.inf)]
    places, at = {}, 0
    for name, width in [(h.name + h.tag, sum(p.width for p in h.effect.parameters)) for h in fresh] + [
        (n, 1) for n in extra
    ]:
        places[name] = np.arange(at, at + width)
        at += width
    return Joint(places, (information + information.T) / 2, gradient, np.concatenate(prior))


def _marked(rows: Rows, columns: Columns) -> Rows:
    """Return rows that also depend on the columns."""
    blocks = {(n, CONSTANT): groups[rows.name][:, :, None] for n, groups in columns.items() if rows.name in groups}
    return replace(rows, residual=Jet(rows.residual.value, rows.residual.blocks | blocks)) if blocks else rows


def mark(fit: Fit, state: State, gone: Sequence[Hypothesis]) -> tuple[Model, State, dict[str, Array]]:
    """Return the model without some effects, its state at the same motion, and what they add to every group."""
    rest = tuple(h for h in fit.model.hypotheses if h not in gone)
    without = extended(replace(fit, state=state), rest)
    quiet = dict.fromkeys([*fit.noise, *without.noise], 1.0)
    own = [h.key("") for h in gone]
    rows = [all_rows(m, s, quiet, fit.anchor) for m, s in ((fit.model, state), (without.model, without.state))]
    has, lacks = ({r.name: r for r in some if not _of(r, own)} for some in rows)
    added = {n: has[n].residual.value - r.residual.value for n, r in lacks.items() if n in has}
    return without.model, without.state, {n: x for n, x in added.items() if np.any(x)}


def _of(rows: Rows, own: list[str]) -> bool:
    """Return whether rows are a prior or a law of these effects alone."""
    return any(
        rows.name.removeprefix(kind).startswith(key) for kind in ("", "prior.", "smooth.", "size.") for key in own
    )


def alternatives(model: Model, h: Hypothesis) -> list[Hypothesis]:
    """Return what could stand in an effect's place: every law that is near linear, and the other clock."""
    recording = model.recording
    taken = {other.name for other in model.hypotheses}
    out = [Hypothesis(effect, at) for effect, at in possible(recording) if effect.parameters and not effect.states]
    if h.effect.name in CLOCKS:
        out += [Hypothesis(h.effect, i.name) for i in recording.imus]
    out = [r for r in out if r.name not in taken and not r.effect.grid(1.0)]
    return list({r.name: r for r in out}.values())


def late(fit: Fit, h: Hypothesis) -> tuple[Imu, float] | None:
    """Return the IMU that reads late where an effect is a clock's offset, its own or the other of two, and by what."""
    if h.effect.name != "time_offset":
        return None
    recording, offset = fit.model.recording, float(fit.state.values[h.key("offset")][0])
    own = [i for i in recording.imus if i.name == h.at]
    others = [] if recording.encoders or recording.poses else [i for i in recording.imus if i.name != h.at]
    return next(((i, abs(offset)) for i in (own if offset > 0 else others)), None)


def filters(model: Model, state: State, imu: Imu, delay: float) -> Columns:
    """Return what low-pass filters of some cutoffs would add at an IMU, in the place of a delay in s."""
    read = {r.name: r.residual.value for r in model.measured(state)}
    out: Columns = {}
    names = [f"{imu.name}.gyro", f"{imu.name}.accel"]
    if delay <= 0 or any(len(read[n]) != len(imu.time) for n in names):
        return {}
    count = int(np.ceil(len(imu.time) / (FINE * delay * imu.rate))) + len(imu.time)
    fine = np.linspace(imu.time[0], imu.time[-1], count)
    w, f = (CubicSpline(imu.time, read[n] + x)(fine) for n, x in zip(names, (imu.gyro, imu.accel), strict=True))
    for effect in (e for e in VARIANTS if e.name == "low_pass" and not e.variant):
        for factor in (0.8, 0.9, 1.0, 1.1, 1.25):
            cutoff = factor / (2 * np.pi * delay)
            _, g, a = effect.corrupt(fine, w, f, {"cutoff": np.array(cutoff)}, np.random.default_rng(0))
            added = {names[0]: g - w, names[1]: a - f}
            out[f"{effect.name} {cutoff:.3g}"] = {n: interpolated(imu.time, fine, x) for n, x in added.items()}
    return out


def _left(both: Joint, wanted: Array, by: Array) -> float:
    """Return what is lost when a direction (k,) stands for another, its size near 1: cutoffs between those tried."""
    pull = by @ both.information @ by
    size = float(np.clip(by @ both.information @ wanted / max(float(pull), 1e-300), 1 / NEAR, NEAR))
    rest = wanted - size * by
    return 0.5 * float(rest @ both.information @ rest)


def rivals(fit: Fit, h: Hypothesis, sure: bool = True) -> list[Rival]:
    """Return what every other effect would lose in the place of `h`, a kept effect of the fit, the closest first.

    `sure`: the closest few are refitted exactly, for a law far from linear seems to lose more than it does.
    """
    bare, still, added = mark(fit, fit.state, [h])
    others = alternatives(fit.model, h)
    model = bare.with_effects((*bare.hypotheses, *others))
    begun = extended(replace(fit, model=bare, state=still), model.hypotheses)
    slow = late(fit, h)
    smooth = filters(bare, State(still.coefficients, fit.state.values), *slow) if slow else {}
    both = joint(begun.model, begun.state, fit, others, {MARK: added} | smooth)
    wanted = both.along(MARK)[:, 0]
    total = 0.5 * float(wanted @ both.information @ wanted)
    found: list[tuple[Rival, Hypothesis | None, Array]] = []
    for r in others:
        loss, size = both.explained(wanted, both.along(r.name))
        start = np.concatenate([p.centre for p in r.effect.parameters])
        found.append((Rival(r.effect.name, r.at, loss), r, start + size))
    scales = [r.name for r in others if r.effect.name == "accel_scale"]
    if h.effect.name == "gravity" and scales:
        loss, size = both.explained(wanted, both.along(*scales).sum(axis=1, keepdims=True))
        found += [(Rival("accel_scale", n.split("@")[1], loss), None, size) for n in scales]
    if slow and smooth:
        loss = min(_left(both, wanted, both.along(n)[:, 0]) for n in smooth)
        found.append((Rival("low_pass", slow[0].name, loss), None, np.zeros(0)))
    found.sort(key=lambda f: f[0].loss)
    if sure:
        close = [f for f in found if f[1] is not None and LIKE < f[0].loss < DOUBT * total][:REFITTED]
        tried = [(_refitted(fit, h, r, guess), r, guess) for _, r, guess in close if r is not None]
        found += [(t, r, guess) for t, r, guess in tried if t is not None]
    best: dict[tuple[str, str], Rival] = {}
    for rival, _, _ in sorted(found, key=lambda f: f[0].loss):
        best.setdefault((rival.effect, rival.at), rival)
    best.pop((h.effect.name, h.at), None)
    return sorted(best.values(), key=lambda r: r.loss)


def _refitted(fit: Fit, h: Hypothesis, rival: Hypothesis, guess: Array) -> Rival | None:
    """Return what the fit, or its evidence, really loses with another effect in the place of `h`."""
    rest = tuple(other for other in fit.model.hypotheses if other != h)
    try:
        tried = refit(fit, (*rest, rival), guess_of(rival, guess))
    except NotPositiveDefiniteError:
        return None
    # the evidence, because parameters of `h` that only fitted noise are no loss
    lost = min(tried.cost - fit.cost, log_evidence(fit) - log_evidence(tried))
    return Rival(rival.effect.name, rival.at, max(lost, 0.0), exact=True)


def alike(fit: Fit, h: Hypothesis) -> list[Rival]:
    """Return what the recording cannot tell from `h`, a kept effect of the fit, the closest first."""
    found = {(r.effect, r.at): r for r in rivals(fit, h) if r.loss < LIKE}
    scales = [other for other in fit.model.hypotheses if other.effect.name == "accel_scale"]
    if h in scales and len(scales) == len(fit.model.recording.imus):
        loss = _all_scaled(fit, scales)
        if loss < LIKE:
            found[("gravity", "world")] = Rival("gravity", "world", loss)
    return sorted(found.values(), key=lambda r: r.loss)


def _all_scaled(fit: Fit, scales: Sequence[Hypothesis]) -> float:
    """Return what is lost when another gravity stands for the scales of all accelerometers."""
    recording = fit.model.recording
    if "world" not in EFFECTS["gravity"].places(recording):
        return np.inf
    weight = Hypothesis(EFFECTS["gravity"].suited(recording), "world")
    if weight.name in {h.name for h in fit.model.hypotheses}:
        return np.inf
    bare, still, added = mark(fit, fit.state, scales)
    begun = extended(replace(fit, model=bare, state=still), (*bare.hypotheses, weight))
    both = joint(begun.model, begun.state, fit, [weight], {MARK: added})
    return both.explained(both.along(MARK)[:, 0], both.along(weight.name))[0]


__all__ = ["Joint", "Rival", "alike", "joint", "late", "mark", "rivals"]

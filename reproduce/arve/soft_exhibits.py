"""The study of soft tissue as figures and tables; each title says what the run found."""

from collections.abc import Iterable

import numpy as np

from imubench.arrays import Array
from imubench.reproduce.arve import soft_draw
from imubench.reproduce.arve.soft_draw import LABELS
from imubench.reproduce.arve.soft_results import BANDS, FINE, HUNG, MID, NOISIER, SHOWN, Soft
from imubench.reproduce.arve.soft_runs import DAMPING, KINDS, METHODS, NOISE, SETTLED, UNASSUMED
from imubench.reproduce.paper import Arrays, Figure, Table

CASES = {"none": "r constant", "paper": "unfelt", "sliding": "felt", "sprung": "spring"}
TOLD = {"told": "UKF, first orientation told", "ukf": "UKF, not told"}


def exhibits(s: Soft) -> tuple[Figure | Table, ...]:
    """Return them in the order of the argument."""
    return (maps(s), explanations(s), sprung(s), shown(s), bounds(s), limits(s))


def counted(number: int, what: str) -> str:
    """Return "1 run", "2 runs"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def mid(s: Soft, kind: str, method: str, gyro: float = 1.0) -> Array:
    """Return |dr| in mm (frequencies, phases) at 20 mm."""
    return np.asarray(1e3 * s.maps[kind, gyro][method][s.extent.amplitudes.index(MID)])


def at(s: Soft, kind: str, method: str, frequency: float = 1.0, gyro: float = 1.0) -> float:
    """Return |dr| in mm at 20 mm and one frequency: that of the first phase, which every run has."""
    return float(mid(s, kind, method, gyro)[s.extent.frequencies.index(frequency), 0])


def maps(s: Soft) -> Figure:
    """Return the maps of felt and unfelt slides."""
    felt = {m: mid(s, "sliding", m) for m in METHODS}
    best = min((m for m in METHODS if m != "sliding"), key=lambda m: felt[m].mean())
    finding = (
        f"Once a slide of 20 mm is felt, {LABELS[best]} is the best of the known methods, and {felt[best].min():.0f} "
        f"to {felt[best].max():.0f} mm off; sliding stays within {felt['sliding'].max():.1f} mm, and within "
        f"{mid(s, 'paper', 'sliding').max():.1f} mm of an unfelt one"
    )
    text = (
        "Mean |Δr| of a record over the slide's frequency and amplitude (that of x and z; y has a quarter). Top: the "
        "accelerometer feels the slide. Bottom: it does not, as the paper has it. The orientation is known, the sensor "
        f"has its noise; means over {counted(s.extent.phases, 'phase')}. The paper's limit of what is "
        "useful is a tenth of |r|, 20 mm. Row 0: r constant, filters with their covariances for one."
    )
    return Figure("soft-maps", "Maps", finding, text, lambda: soft_draw.maps(s))


def explanations(s: Soft) -> Figure:
    """Return what the gyroscope's noise has to do with it."""
    with_, without = at(s, "sliding", "mrvs"), at(s, "sliding", "mrvs", gyro=0.0)
    constant = 1e3 * s.noisier["none"]
    needed = _crossing(np.array(NOISIER), constant, 65.0)
    finding = (
        f"It is the slide, not the gyroscope: MrVS is {with_:.1f} mm off with the gyroscope's noise and {without:.1f} "
        f"mm without; to make 65 mm of a constant r the gyroscope would have to be {needed:.0f} times as noisy"
    )
    text = (
        "Left: MrVS by the noise of the gyroscope, in multiples of the sensor's 0.0017 rad/s, for a constant r and for "
        "20 mm at 1 Hz; mean of 10 runs, w' by central difference. Dotted: the 65 mm that the paper measured on real "
        "hips. Right: all methods over the frequency of a felt slide of 20 mm, phase 0, with the gyroscope's noise "
        "(lines) and without (crosses)."
    )
    return Figure("soft-explanations", "Two explanations", finding, text, lambda: soft_draw.explanations(s))


def _crossing(x: Array, y: Array, level: float) -> float:
    """Return where y, growing, passes a level, between its points in their logarithms; NaN if it does not."""
    above = np.flatnonzero(y > level)
    if not above.size or above[0] == 0:
        return float("nan")
    k = int(above[0])
    low = np.log(np.maximum(x[k - 1 : k + 1], 1e-3))
    part = np.log(level / y[k - 1]) / np.log(y[k] / y[k - 1])
    return float(np.exp(low[0] + part * (low[1] - low[0])))


def sprung(s: Soft) -> Figure:
    """Return the errors over the spring's frequency."""
    e, found = s.extent, s.springs[1.0]
    z, k = e.dampings.index(DAMPING), e.springs.index(HUNG)
    filtered, constant, ours = (1e3 * found[m][z, k] for m in ("arve-d", "mrvs", "sliding"))
    finding = (
        f"On springs of {HUNG:g} Hz, which give way by 20 mm, ArVE_d is {filtered:.0f} mm off, MrVS {constant:.1f} mm "
        f"and sliding {ours:.1f} mm; over all springs sliding is {1e3 * found['sliding'].max():.1f} mm off at most"
    )
    text = (
        f"Mean |Δr| over the frequency of springs along the limb's axes, damping ratio {DAMPING:g}; about them they "
        "have 9 Hz. In brackets by how much the sensor is displaced at most, for the most part by its own weight. "
        "Lines: with the gyroscope's noise; crosses: without. Black: the best constant, the mean of the true r."
    )
    return Figure("soft-sprung", "Springs", finding, text, lambda: soft_draw.sprung(s))


def shown(s: Soft) -> Table:
    """Return batch and stream beside ArVE_d."""
    columns = ("case", "ArVE_d", "MrVS", "sliding", "worst run", "chosen", "sliding-stream", "worst run", "filter bank")
    rows = []
    for name, found in s.shown.items():
        chosen = ", ".join(sorted({KINDS[int(k)] for k in found["kind"]}))
        means = [f"{1e3 * found[m].mean():.2f}" for m in ("arve-d", "mrvs", "sliding")]
        worst, stream = f"{1e3 * found['sliding'].max():.2f}", 1e3 * found["stream"]
        rows.append(
            (
                case(name),
                *means,
                worst,
                chosen,
                f"{stream.mean():.2f}",
                f"{stream.max():.2f}",
                f"{1e3 * found['bank'].mean():.2f}",
            )
        )
    batch, stream = (1e3 * max(f[m].max() for f in s.shown.values()) for m in ("sliding", "stream"))
    bank = max(f["bank"].mean() for f in s.shown.values())
    finding = f"Over all cases sliding is {batch:.1f} mm off at most, its stream {stream:.1f} mm; a filter with "
    finding += f"the slide in its state {1e3 * bank:.0f} mm"
    text = (
        f"Mean |Δr| in mm; {counted(s.extent.seeds, 'run')} of other noise and phase each. The stream is judged from "
        f"{SETTLED:g} s on, the rest over the record. ArVE_d has its covariances for a constant r where r is constant. "
        "Chosen: the kind of r of the largest evidence. Filter bank: extended Kalman filters with one felt slide in "
        "their state, from seven frequencies, the most probable answering; judged as the stream is."
    )
    return Table("soft-shown", "At 20 mm", finding, text, columns, tuple(rows))


def case(name: str) -> str:
    """Return the words for a case of SHOWN."""
    cell = SHOWN[name]
    if cell.kind == "none":
        return CASES[cell.kind]
    if cell.kind == "sprung":
        return f"spring, {cell.frequency:g} Hz"
    return f"{CASES[cell.kind]}, 20 mm at {cell.frequency:g} Hz"


def bounds(s: Soft) -> Figure:
    """Return what any estimator could know."""
    b = s.bounds
    one, sought = 1e3 * float(b["only"]), 1e3 * b["sought"]
    free, tight = 1e3 * b["free 0.03"], 1e3 * b["free 0.003"]
    finding = (
        f"A slide of one frequency costs little, at worst at {FINE[np.argmax(sought)]:.2g} Hz, where the limb swings: "
        f"{sought.max():.2f} mm instead of {one:.2f}. A slide of any shape up to {BANDS[-1]:g} Hz leaves "
        f"{free[-1]:.0f} mm: no estimator can tell it"
    )
    text = (
        f"Cramér-Rao bounds of r(t), root mean square over 10 s, from the motion and {NOISE[1]:g} m/s² of noise alone, "
        "computed without the estimators' equations. Left: one slide of unknown frequency, 20 mm; dots: what sliding "
        "reached on single runs, which may lie below. Right: a slide of any waves up to a frequency, each number of "
        "which is known to 30 or 3 mm before; the vector that rests in the world, R(t)ᵀc, is such a slide from twice "
        f"the swing's frequency on ({tight[-1]:.0f} mm with 3 mm waves)."
    )
    return Figure("soft-bounds", "Bounds", finding, text, lambda: soft_draw.bounds(s))


def limits(s: Soft) -> Table:
    """Return what is not assumed, and gravity by filters."""
    columns = ("case", "ArVE_d", "MrVS", "sliding", "sliding-stream", "chosen", "residual power")
    rows = [_limit(UNASSUMED[name], found) for name, found in s.others.items()]
    for key, found in s.gravity.items():
        name, way = key.rsplit(" ", 1)
        rows.append(_limit(f"{case(name)}; gravity by {TOLD[way]}", found))
    band = 1e3 * s.others["band"]["sliding"].mean() if "band" in s.others else float("nan")
    finding = f"Where a slide is made of many waves sliding fails, by {band:.0f} mm, and its residual power says so"
    text = (
        "Mean |Δr| in mm where something is not as sliding assumes, and with gravity taken out by an orientation "
        "filter instead of the known orientation. Residual power: what is left over that of the noise; above 2 "
        "sliding gives no covariance."
    )
    return Table("soft-limits", "Limits", finding, text, columns, tuple(rows))


def _limit(label: str, found: Arrays) -> tuple[str, ...]:
    chosen = ", ".join(sorted({KINDS[int(k)] for k in found["kind"]}))
    return label, *_means(found, ("arve-d", "mrvs", "sliding", "stream")), chosen, f"{found['residual'].max():.3g}"


def _means(found: Arrays, names: Iterable[str]) -> tuple[str, ...]:
    return tuple(f"{1e3 * found[m].mean():.2f}" for m in names)

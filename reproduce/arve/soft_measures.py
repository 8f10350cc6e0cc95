"""What the claims about soft tissue are measured by."""

from collections.abc import Callable

import numpy as np

from imubench.reproduce.arve.soft_exhibits import at, case, mid
from imubench.reproduce.arve.soft_results import Soft
from imubench.reproduce.arve.soft_runs import SETTLED
from imubench.reproduce.claims import Measured


def felt_error(s: Soft) -> Measured:
    """Return MrVS's mean |dr| in mm with a felt slide of 20 mm at the swing's frequency."""
    low, high = mid(s, "sliding", "mrvs").min(), mid(s, "sliding", "mrvs").max()
    why = (
        f"20, 5 and 20 mm at 1 Hz, phase 0; over the frequencies and phases of the maps {low:.1f} to {high:.1f} mm. "
        f"Unfelt, as the paper simulates it: {at(s, 'paper', 'mrvs'):.1f} mm"
    )
    return Measured(at(s, "sliding", "mrvs"), why)


def gyroscopes_share(s: Soft) -> Measured:
    """Return how much of that goes away without gyroscope noise, in %."""
    noisy, quiet = at(s, "sliding", "mrvs"), at(s, "sliding", "mrvs", gyro=0.0)
    constant = 1e3 * s.noisier["none"]
    why = (
        f"{noisy:.2f} mm with the gyroscope's noise, {quiet:.2f} mm without, the same slide and accelerometer noise; "
        f"on a constant r its noise makes {constant[1]:.2f} mm, a gyroscope 10 times as noisy {constant[3]:.1f} mm"
    )
    return Measured(float(100 * (1 - quiet / noisy)), why)


def worst(s: Soft, kind: str, method: str) -> Measured:
    """Return the worst mean |dr| in mm of single runs over the cases of one kind, 20 mm."""
    found = {name: 1e3 * f[method].max() for name, f in s.shown.items() if name.startswith(kind)}
    if method == "sliding" and kind in ("sliding", "paper"):
        for f, errors in zip(s.extent.frequencies, mid(s, kind, method), strict=True):
            found[f"map, {f:g} Hz"] = float(errors.max())
    name = max(found, key=lambda n: found[n])
    where = case(name) if name in s.shown else name
    late = f", from {SETTLED:g} s on" if method == "stream" else ""
    return Measured(float(found[name]), f"the worst of {len(found)} cases, {where}{late}")


def against(s: Soft, kind: str, method: str, rival: str) -> Measured:
    """Return mean |dr| of one method over that of a rival, the worst case of one kind."""
    ratios = {n: float(f[method].mean() / f[rival].mean()) for n, f in s.shown.items() if n.startswith(kind)}
    name = max(ratios, key=lambda n: ratios[n])
    found = s.shown[name]
    why = f"{1e3 * found[method].mean():.2f} mm against {1e3 * found[rival].mean():.2f} mm, {case(name)}"
    return Measured(ratios[name], why)


def free_bound(s: Soft) -> Measured:
    """Return the Cramer-Rao bound in mm for a slide of any shape up to 3 Hz."""
    free = 1e3 * s.bounds["free 0.03"]
    sought = 1e3 * s.bounds["sought"]
    one = f"one slide of unknown frequency: {sought.min():.2f} to {np.max(sought):.2f} mm"
    why = f"{one}; any up to 6 Hz: {free[-1]:.0f} mm"
    return Measured(float(free[7]), why)


Measure = Callable[[Soft], Measured]

MEASURES: dict[str, Measure] = {
    "felt_error": felt_error,
    "gyroscopes_share": gyroscopes_share,
    "sliding_batch": lambda s: worst(s, "sliding", "sliding"),
    "sprung_batch": lambda s: worst(s, "sprung", "sliding"),
    "sliding_stream": lambda s: worst(s, "sliding", "stream"),
    "sprung_stream": lambda s: worst(s, "sprung", "stream"),
    "constant_ratio": lambda s: against(s, "constant", "sliding", "arve-d"),
    "paper_ratio": lambda s: against(s, "paper", "sliding", "arve-d"),
    "constant_stream_ratio": lambda s: against(s, "constant", "stream", "arve-d late"),
    "paper_stream_ratio": lambda s: against(s, "paper", "stream", "arve-d late"),
    "free_bound": free_bound,
}

"""What `sliding` is instead of: an r of any shape, and what biases do: python -m benchmarks.sliding_shapes [SEEDS]

Prints the two tables of docs/soft-tissue.md. Of any shape: r is a constant and a spline, or the state of a Kalman
filter; how rough it may be is taken by its evidence, as is whether it is felt. The filters are told the true w and w'.
The orientation is known.
"""

import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
from scipy.interpolate import BSpline

from imubench.arrays import Array
from imubench.estimators import sliding
from imubench.estimators.centre_ekf import covariances_of
from imubench.estimators.centre_runs import track
from imubench.estimators.mrvs import solve_differenced
from imubench.estimators.sliding_lines import LINE_STD, R_STD, evidence
from imubench.estimators.sliding_rows import Rows
from imubench.reproduce.arve.runs import Runs, removed
from imubench.reproduce.arve.soft_results import SHOWN
from imubench.reproduce.arve.soft_runs import NOISE, SETTLED, Cell, recorded, rows_of, truth_of

SPACING, DEGREE = 0.06, 5  # s between knots: a wave of 3 Hz to a thousandth of its acceleration
ROUGH = np.geomspace(1e-6, 0.1, 11)  # m, of the second differences of a spline's numbers
JERK = np.geomspace(1e-2, 1e3, 11)  # m/s^3 per root hertz
ALONG = np.array([1.0, -1.0, 1.0]) / np.sqrt(3)  # of biases
BIASES = ((0.0, 0.0), (5e-3, 0.0), (0.0, 6e-3), (0.0, 0.06))  # rad/s, m/s^2; 5e-3 rad/s is 0.29 deg/s
BIASED = ("constant", "paper 1", "sliding 0.3", "sliding 1", "sliding 3", "sprung 3.7")  # names of SHOWN
Answer = tuple[float, Array]
"""Log evidence in nat, and r (n, 3) in m."""


@cache
def basis(count: int, step: float) -> tuple[Array, Array]:
    """Return splines and their rates (count, columns) at even samples."""
    time = np.arange(count) * step
    inner = np.linspace(0, time[-1], round(time[-1] / SPACING) + 1)
    knots = np.concatenate([np.zeros(DEGREE), inner, np.full(DEGREE, time[-1])])
    all_of = BSpline(knots, np.eye(knots.size - DEGREE - 1), DEGREE)
    return all_of(time), all_of(time, 1)


def smoothed(rows: Rows, felt: bool) -> Answer:
    """Return r as a constant and a spline, small and smooth before any sample, of the roughness of most evidence."""
    n, values = rows.time.size, basis(rows.time.size, rows.step)
    r, rate = (np.einsum("nc,ik->nick", x, np.eye(3)).reshape(n, 3, -1) for x in values)
    fixed = np.broadcast_to(np.eye(3), (n, 3, 3))
    A = np.hstack([rows.predicted(fixed, np.zeros((n, 3, 3)), felt), rows.predicted(r, rate, felt), rows.tilted])
    y, m = rows.measured, values[0].shape[1]
    G, b = A.T @ A, A.T @ y
    bent = np.diff(np.eye(m), 2, axis=0)
    best: Answer = -np.inf, np.empty(0)
    for rough in ROUGH:
        prior = np.linalg.cholesky(np.linalg.inv(bent.T @ bent / rough**2 + np.eye(m) / LINE_STD**2))
        S = np.zeros_like(G)
        S[:3, :3], S[-6:, -6:] = R_STD * np.eye(3), rows.gravity[1] * np.eye(6)
        S[3:-6, 3:-6] = np.kron(prior, np.eye(3))
        found, x, _ = evidence(S.T @ G @ S, S.T @ b, float(y @ y), y.size)
        if found > best[0]:
            x = S @ x
            best = float(found), x[:3] + r @ x[3:-6]
    return best


def crossing(w: Array) -> Array:
    """Return [w]x (n, 3, 3)."""
    return np.cross(w[:, None, :], np.eye(3)).transpose(0, 2, 1)


def measuring(w: Array, dw: Array, felt: bool) -> Array:
    """Return what a = H (r, r', r'') is made by: H (n, 3, 9)."""
    W, one = crossing(w), np.broadcast_to(np.eye(3), (w.shape[0], 3, 3))
    return -np.concatenate([crossing(dw) + W @ W, felt * 2 * W, felt * one], axis=2)


def filtered(a: Array, H: Array, step: float, F: Array, Q: Array, P: Array) -> Answer:
    """Return r by a Kalman filter of state x -> F x + noise of Q, from zeros with covariance P."""
    x, total, noise = np.zeros(F.shape[0]), 0.0, NOISE[1] ** 2 * np.eye(3)
    r = np.empty_like(a)
    for k in range(a.shape[0]):
        x, P = F @ x, F @ P @ F.T + Q
        S, e = H[k] @ P @ H[k].T + noise, a[k] - H[k] @ x
        K = np.linalg.solve(S, H[k] @ P).T
        x, P = x + K @ e, P - K @ S @ K.T
        P = 0.5 * (P + P.T)
        total -= 0.5 * (e @ np.linalg.solve(S, e) + np.linalg.slogdet(S)[1])
        r[k] = x[:3]
    return float(total), r


def by_jerk(runs: Runs, felt: bool) -> Answer:
    """Return r whose third derivative is white noise, its size by evidence."""
    t, w = runs.time, runs.truth.gyro
    h, H = float(t[1] - t[0]), measuring(w, np.gradient(w, t, axis=0, edge_order=2), felt)
    F = np.kron([[1, h, h * h / 2], [0, 1, h], [0, 0, 1]], np.eye(3))
    q = np.array([[h**5 / 20, h**4 / 8, h**3 / 6], [h**4 / 8, h**3 / 3, h**2 / 2], [h**3 / 6, h**2 / 2, h]])
    P = np.diag(np.repeat([R_STD, 0.2, 2.0], 3) ** 2)
    a = removed(runs, "known")[0]
    return max((filtered(a, H, h, F, j**2 * np.kron(q, np.eye(3)), P) for j in JERK), key=lambda x: x[0])


def told(runs: Runs, felt: bool, frequency: float) -> Answer:
    """Return r by a filter that is told the frequency: the state is r, r' and r0, r'' = -m^2 (r - r0)."""
    t, w, m = runs.time, runs.truth.gyro, 2 * np.pi * frequency
    h, H = float(t[1] - t[0]), measuring(w, np.gradient(w, t, axis=0, edge_order=2), felt)
    c, s = np.cos(m * h), np.sin(m * h)
    F = np.kron([[c, s / m, 1 - c], [-m * s, c, m * s], [0, 0, 1]], np.eye(3))
    to = np.kron([[1, 0, 0], [0, 1, 0], [-(m**2), 0, m**2]], np.eye(3))  # r, r', r'' of the state
    size = np.kron([[1, 0, 1], [0, 1, 0], [0, 0, 1]], np.eye(3))  # s + r0, s', r0
    P = size @ np.diag(np.repeat([LINE_STD, m * LINE_STD, R_STD], 3) ** 2) @ size.T
    return filtered(removed(runs, "known")[0], H @ to, h, F, np.zeros((9, 9)), P)


def chosen(of: Callable[[bool], Answer]) -> Array:
    """Return r of what has more evidence, felt or unfelt."""
    return max(of(True), of(False), key=lambda x: x[0])[1]


def errors(cell: Cell, seed: int) -> list[float]:
    """Return mean |dr| in mm: spline, `sliding`, and from SETTLED on the two filters."""
    runs = recorded(truth_of(cell), seed)
    rows, late = rows_of(runs, removed(runs, "known")), round(SETTLED / (runs.time[1] - runs.time[0]))
    found = [chosen(lambda felt: smoothed(rows, felt)), sliding.answer(sliding.best(rows), runs.time)[0]]
    found.append(chosen(lambda felt: by_jerk(runs, felt)))
    if cell.kind in ("sliding", "paper"):
        found.append(chosen(lambda felt: told(runs, felt, cell.frequency)))
    off = [1e3 * np.linalg.norm(r - runs.r, axis=1) for r in found]
    return [float(e[late if i > 1 else 0 :].mean()) for i, e in enumerate(off)] + [np.nan] * (4 - len(off))


def biased(cell: Cell, seed: int, gyro: float, accel: float) -> list[float]:
    """Return mean |dr| in mm of ArVE_d, MrVS and `sliding`, and the residual power of the last; orientation known."""
    runs = recorded(truth_of(cell), seed)
    a = removed(runs, "known") + accel * ALONG
    runs = replace(runs, gyro=runs.gyro + gyro * ALONG, accel=runs.accel + accel * ALONG)
    covariances = covariances_of("arve-d", "constant" if cell.kind == "none" else "varying")
    tracks = track(runs.gyro, a, runs.time, 12, covariances)
    fit = sliding.best(rows_of(runs, a))
    found = (solve_differenced(runs.gyro[0], a[0], runs.time)[0], sliding.answer(fit, runs.time)[0])
    off = [np.linalg.norm(tracks.r[0] - runs.r[tracks.first :], axis=1)]
    off += [np.linalg.norm(r - runs.r, axis=1) for r in found]
    return [float(1e3 * e.mean()) for e in off] + [fit.noise]


def by_shape(seeds: int) -> None:
    print("| soft tissue | spline | sliding | filter, r of any shape | filter, frequency told |\n|---|" + "---:|" * 4)
    for name, cell in SHOWN.items():
        means = np.mean([errors(cell, seed) for seed in range(seeds)], axis=0)
        cells = ["" if np.isnan(e) else f"{e:.2f}" if e < 10 else f"{e:.0f}" for e in means]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


def by_bias(seeds: int) -> None:
    print(
        "\n| soft tissue | gyro bias, rad/s | accel bias, m/s^2 | ArVE_d | MrVS | sliding | power |\n|---|"
        + "---:|" * 6
    )
    for name in BIASED:
        for gyro, accel in BIASES:
            means = np.mean([biased(SHOWN[name], seed, gyro, accel) for seed in range(seeds)], axis=0)
            cells = " | ".join(f"{x:.2f}" if x < 10 else f"{x:.0f}" for x in means)
            print(f"| {name} | {gyro:g} | {accel:g} | {cells} |", flush=True)


def main(seeds: int) -> None:
    by_shape(seeds)
    by_bias(seeds)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1)

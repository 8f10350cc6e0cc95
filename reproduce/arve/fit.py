"""How the covariances of ArVE and ArVE_d, which the paper does not publish, were fitted: once, on one run.

`python -m imubench.reproduce.arve.fit` prints the numbers that estimators/arve_covariances.toml holds. The run is the
varying r with the noise of seed 100 and the true orientation; what is judged are other seeds. Minimised is the mean of
|dr| over the driving noise of w' and of r (ArVE) or r' (ArVE_d); P0 and R stay as argued there.
"""

from dataclasses import replace

import numpy as np
from scipy.optimize import minimize

from imubench.arrays import Array
from imubench.estimators import frick_rahmatalla
from imubench.estimators.centre_ekf import Covariances, covariances_of
from imubench.estimators.centre_runs import track
from imubench.reproduce.arve.runs import Runs, noisy, played, removed
from imubench.score import vector_error

SEED = 100
STATES = {"arve-d": 12, "arve": 9}
STARTS = {  # what the argument in the TOML file gives
    "arve-d": {"angular_acceleration_density": 5.2, "r_rate_density": 0.32},
    "arve": {"angular_acceleration_density": 5.2, "r_density": 0.05},
}


def experiment() -> tuple[Runs, Array]:
    """Return the one run of the fit, and its acceleration (1, n, 3) in m/s^2."""
    runs = noisy(played(varying=True), SEED)
    return runs, removed(runs, "known")


def with_densities(covariances: Covariances, names: list[str], logs: Array) -> Covariances:
    """Return covariances with the named densities replaced by the exponentials of `logs`."""
    return replace(covariances, **dict(zip(names, np.exp(logs).tolist(), strict=True)))


def fitted(name: str) -> dict[str, float]:
    """Return the fitted densities of one filter by their names, in the units of `Covariances`."""
    runs, acceleration = experiment()
    names, start = list(STARTS[name]), np.log(list(STARTS[name].values()))
    others = covariances_of(name)

    def mean_error(logs: Array) -> float:
        tracks = track(
            runs.gyro, acceleration, runs.time, STATES[name], with_densities(others, names, np.asarray(logs))
        )
        return float(vector_error(tracks.r, runs.r[tracks.first :])[0].mean())

    simplex = start + np.array([[0.0, 0.0], [0.5, 0.0], [0.0, -0.5]])
    options = {"initial_simplex": simplex, "xatol": 0.005, "fatol": 1e-7}
    found = minimize(mean_error, start, method="Nelder-Mead", options=options)
    return dict(zip(names, np.exp(found.x).tolist(), strict=True))


def descents() -> dict[tuple[int, int], float]:
    """Return the mean |dr| in m of the gradient descent by its half width and its steps, on the same run."""
    runs, acceleration = experiment()
    errors = {}
    for half in (1, 2, 3, 4, 5, 7):
        for steps in (1, 2, 3, 5, 10, 100):
            r = frick_rahmatalla.follow(runs.gyro, acceleration, runs.time, half=half, steps=steps)
            errors[half, steps] = float(vector_error(r, runs.r[half : len(runs.r) - half])[0].mean())
    return errors


if __name__ == "__main__":
    for name in STATES:
        print(f'["{name}".varying]')
        for key, value in fitted(name).items():
            print(f"{key} = {value:.3g}")
    print("gradient descent: half width, steps, mean |dr| in mm")
    for (half, steps), error in descents().items():
        print(f"{half} {steps} {1e3 * error:.2f}")

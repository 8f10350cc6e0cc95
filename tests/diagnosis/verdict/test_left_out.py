"""A channel left out, foretold in one linear step, against a fit to which its noise makes it worth nothing."""

from dataclasses import replace

import numpy as np
import pytest

from imubench.diagnosis.noise.nominal import nominal_fit
from imubench.diagnosis.solve.levenberg_marquardt import solve
from imubench.diagnosis.verdict.left_out_sensor import left_out
from imubench.format1 import read
from imubench.proof.case import make_case


@pytest.mark.slow
def test_one_step_foretells_as_a_fit_without_the_sensor(tmp_path):
    make_case(tmp_path / "r", "hinge", [("gyro_scale", "imu2")], 3, seconds=8.0)
    fit = nominal_fit(read(tmp_path / "r")[0])
    said = left_out(fit, fit.noise)
    assert len(said) == 12 and min(said.values()) > 0.9  # nothing is foretold better than its noise
    for group, names in (("imu2.gyro", ("gyr_x", "gyr_y", "gyr_z")), ("imu1.accel", ("acc_x", "acc_y", "acc_z"))):
        fixed = {name: fit.state.values[name] for name in fit.model.priors}
        model = replace(fit.model, fixed=fixed)
        blind = solve(model, fit.state, fit.noise | {group: 1e5 * fit.noise[group]}, fit.anchor, steps=8)
        rows = next(r for r in blind.rows if r.name == group)
        off = np.sqrt(np.mean(rows.residual.value**2, axis=0)) / fit.noise[group]
        seen = [said[f"{group.split('.')[0]}.{n}"] for n in names]
        np.testing.assert_allclose(seen, off, rtol=0.1)  # one step of a problem that is not quite linear

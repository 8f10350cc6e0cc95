"""The equations of an r that slides: what the accelerometer reads, and what it cannot tell."""

import numpy as np
import pytest

from tests.swinging_limb import BIG, first_difference, recorded, slide, turned


@pytest.mark.parametrize("felt", [True, False])
def test_the_rows_say_what_the_accelerometer_reads(felt):
    def r(t):
        return slide(t, BIG, ([0.003, 0.01, -0.004], 2.3, 1.0))

    rows, truth = recorded(r, felt)
    off = rows.predicted(truth[..., None], first_difference(r, rows.time)[..., None], felt)[:, 0] - rows.measured
    # In units of noise; what is left is the smoothed rate's own error. Of the other kind it would be hundreds.
    assert np.abs(off).max() < 0.05


def test_a_vector_that_rests_in_the_world_can_be_added_to_any_felt_r():
    rows, _ = recorded(lambda t: slide(t, BIG))

    def added(t):
        return np.swapaxes(turned(t), 1, 2) @ np.array([0.05, -0.08, 0.1])

    c, rate = added(rows.time), first_difference(added, rows.time)
    unseen = rows.predicted(c[..., None], rate[..., None])
    seen = rows.predicted(c[..., None], 0 * rate[..., None])
    assert np.abs(unseen).max() < 0.05  # of the noise, as above
    assert np.abs(seen).max() > 20  # were it fixed to the sensor, 10 cm could not be overlooked

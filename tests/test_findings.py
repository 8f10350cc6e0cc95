"""What a finding tells: numbers read off fitted ones carry their errors."""

import numpy as np

from imubench.diagnosis.findings import carried
from imubench.diagnosis.hypothesis import Hypothesis
from imubench.effects import EFFECTS


def test_a_hum_s_amplitude_has_the_error_of_its_cosine_and_sine():
    h = Hypothesis(EFFECTS["vibration"], "imu1")
    rng = np.random.default_rng(3)
    amplitude, phase = np.array([0.4, -0.2, 0.0]), 0.9
    values = {"frequency": np.array([17.3]), "cosine": amplitude * np.sin(phase), "sine": amplitude * np.cos(phase)}
    std = {h.key("frequency"): np.array([0.01])}
    std |= {h.key(name): np.array([0.004, 0.006, 0.003]) for name in ("cosine", "sine")}
    found = carried(h, values, std, 0.01)["amplitude"]
    drawn = []
    for _ in range(4000):
        moved = {name: x + std[h.key(name)] * rng.standard_normal(x.size) for name, x in values.items()}
        x = h.effect.read(moved, {}, 0.01)["amplitude"]
        drawn.append(x * np.sign(x[0]))
    np.testing.assert_allclose(found, np.std(drawn, axis=0), rtol=0.05)  # 1.1 % for 4000 draws, and what is not linear

"""The headline: how much is explained, what is left, and how loud the sensors were taken to be."""

from dataclasses import replace

from imubench.diagnosis.report import page
from imubench.diagnosis.report.headline import explained_percent, headline, usual_noise
from imubench.diagnosis.result import Noise
from tests.diagnosis.report.diagnoses import simulated
from tests.diagnosis.test_diagnosis_result import diagnosis, evidence


def test_noise_that_nobody_knows_is_never_only_noise():
    nobody = {"imu1.gyro": Noise(0.3, "rad/s", "unknown"), "imu2.accel": Noise(0.03, "m/s^2", "declared")}
    d, shown = simulated(noise=nobody, verdict="partly explained")
    html = page(d, shown)
    assert "only sensor noise is left" not in html.lower()
    assert "That explains 99 % of what differs." in headline(d)
    assert explained_percent(d) == "99 %"  # 99.97 % is not all
    usual = usual_noise(d, {"imu1": 100.0, "imu2": 100.0})
    assert usual == "imu1.gyro was taken to have 17.2 deg/s per sample, such IMUs usually have 0.097 to 0.35."
    # the profiles' least is the Awinda's 0.0017 rad/s, their most the MTw's 0.05 deg/s/sqrt(Hz) over 50 Hz
    assert "imu1.gyro was taken to have 17.2 deg/s" in html
    both = replace(d, noise=nobody | {"imu2.gyro": nobody["imu1.gyro"]})
    assert usual_noise(both, {"imu1": 100.0, "imu2": 100.0}).startswith(
        "imu1.gyro and imu2.gyro were taken to have 17.2"
    )
    quiet = diagnosis(noise=nobody, verdict="no mismatch", findings=(), where=())
    assert "How loud the sensors are is not known" in headline(quiet)
    assert "what differs is sensor noise" in headline(replace(quiet, noise={}))


def test_without_a_simulation_the_page_speaks_of_the_fit():
    d, shown = diagnosis(), evidence()
    html = page(d, shown)
    assert "With that in it, only sensor noise is left." in html
    assert "4.71 as declared, 1.01 with what was found" in html
    assert explained_percent(d) == "78 %"  # 1 - 1.01 / 4.71
    assert explained_percent(diagnosis(misfit=(0.97, 0.9))) == ""  # nothing differs beyond noise


def test_what_explains_but_leaves_more_than_noise_is_not_called_only_noise():
    d, _ = simulated()
    channels = {n: replace(c, after=3 * c.noise) for n, c in d.simulation.channels.items()}
    left = replace(d, simulation=replace(d.simulation, channels=channels))
    assert "only sensor noise" not in headline(left)
    assert "That explains 97 % of what differs." in headline(left)  # 1 - 2 * 3^2 / (28.3^2 + 5.66^2)


def test_a_simulation_that_follows_the_sensors_either_way_is_not_called_off():
    """A recovered motion may take in a clock's error; then what each finding changes is told instead."""
    d, shown = simulated()
    channels = {n: replace(c, before=0.9 * c.noise, after=c.noise) for n, c in d.simulation.channels.items()}
    same = replace(d, simulation=replace(d.simulation, channels=channels), misfit=(0.99, 1.0))
    assert "off by" not in headline(same) and "With that in it, only sensor noise is left." in headline(same)
    assert explained_percent(same) == ""
    html = page(same, shown)
    assert "the declared model follows the sensors as well" in html
    assert (
        "Without a soft mount that imu2 moves on as on springs the simulated imu2 accelerometer x is off by 0.85"
        in html
    )

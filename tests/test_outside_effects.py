"""Effects from outside the package: injected, found, replayed and reported as our own; a broken one breaks nothing."""

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from imubench import effect_table
from imubench.correction.read_model import read_model
from imubench.correction.replay import truth_of_motion
from imubench.correction.sensor_chain import plays, read_by
from imubench.dataset.effect_ranges import Shown, parse_effect
from imubench.diagnosis.on_disk import diagnose_on_disk
from imubench.effect_reference import section
from imubench.effects import EFFECTS, VARIANTS, possible
from imubench.effects.effect import Reading
from imubench.effects.library import checked
from imubench.errors import InputError
from imubench.explain import glossary_page
from imubench.format1 import write_recording
from imubench.jets import Jet
from imubench.recording import Recording
from imubench.sim import rigs
from imubench.sim.imu_model import Declared, DeclaredMount, observe
from imubench.sim.imu_profile import ChannelProfile, ImuProfile
from imubench.sim.injected import injected_rig, injected_samples
from imubench.sim.motion import AngleMotion
from imubench.sim.play import play
from imubench.sim.signals import hand
from tests.command import here
from tests.test_plugins import imports_as_before, installed, written  # noqa: F401

THEIRS = """
    from dataclasses import replace
    import numpy as np
    from imubench.effects.effect import Effect, Error, Parameter
    from imubench.links import shift

    class GyroSquare(Effect):
        '''Each axis of the gyroscope reads a part of its square.'''

        name, place, law = "gyro_square", "imu", "y_i = x_i + square_i x_i^2"
        phrase, channel = "a gyroscope in {imu} that reads a part of its square", "gyro"
        parameters = (Parameter("square", (3,), "s/rad", 0.02),)

        def error(self, reading, p):
            return Error(gyro=p["square"] * reading.gyro * reading.gyro)

    class Raised(Effect):
        '''A sensor that sits higher, as on a thicker strap; nothing is declared of it but its law.'''

        name, place, law = "raised", "imu", "p = p_model + height e_z"
        parameters = (Parameter("height", (), "m", 0.01),)

        def mount(self, link, scene, p):
            return shift(p["height"].at(np.array([[0.0], [0.0], [1.0]]))) @ link

        def on_mount(self, mount, numbers):
            return replace(mount, position=mount.position + [0.0, 0.0, float(numbers["height"])])

    class Bias(GyroSquare):
        name = "gyro_bias"

    class Hum(GyroSquare):
        name, tone = "gyro_hum", "frequency"

    SQUARE, RAISED, TAKEN, HUM, NONE = GyroSquare(), (Raised(),), Bias(), Hum(), 3
"""
POINTS = "square = their_effects:SQUARE\nraised = their_effects:RAISED"
SQUARE = np.array([0.03, -0.02, 0.04])  # s/rad: at 3 rad/s up to 0.4 rad/s, a hundred times the noise
SECONDS, RATE = 6.0, 50.0
WHITE = ImuProfile("white", RATE, ChannelProfile(noise_std=0.004), ChannelProfile(noise_std=0.02))
INJECTED = {"effect": "gyro_square", "at": "imu2", "parameters": {"square": SQUARE.tolist()}}


@pytest.fixture(autouse=True)
def library_as_before():
    yield
    VARIANTS.look_again()  # where Python looks for packages is as before when the library is next asked


@pytest.fixture
def package(tmp_path):
    """A package with two effects."""
    written(tmp_path / "site" / "their_effects.py", THEIRS)
    installed(tmp_path / "site", "their-effects", POINTS, "imubench.effects")
    VARIANTS.look_again()
    return tmp_path


def recorded() -> Recording:
    """A hinge moved by hand, its mounts known, white noise alone; the effect in its second IMU."""
    rng = np.random.default_rng(1)
    stds = {"heading": 0.8, "tilt": 0.5, "spin": 0.8, "angle": 0.8, "x": 0.1, "y": 0.1, "z": 0.05}
    rig = rigs.hinge()
    truth = play(rig, AngleMotion(**{n: hand(rng, SECONDS, s, 1.0) for n, s in stds.items()}), SECONDS, 500.0)
    mounts = {f"imu{i + 1}": DeclaredMount(m.position, m.quaternion, 1e-3, 5e-3) for i, m in enumerate(rig.mounts)}
    recording = observe(truth, WHITE, rng, "square", Declared(mounts))
    return replace(recording, imus=tuple(injected_samples(i, [INJECTED], rng) for i in recording.imus))


def test_an_effect_of_a_package_is_one_of_the_library(package):
    assert list(EFFECTS)[-2:] == ["gyro_square", "raised"]
    assert {at for effect, at in possible(recorded()) if effect.name == "gyro_square"} == {"imu1", "imu2"}
    assert here("list", "effects").out.count("gyro_square") == 1
    assert "A gyroscope in a sensor that reads a part of its square." in here("explain", "gyro_square").out
    assert "- law: `p = p_model + height e_z`" in list(section("raised", EFFECTS["raised"]))


def test_the_example_of_the_page_is_an_effect_as_it_stands():
    page = (Path(__file__).resolve().parent.parent / "docs" / "add-an-effect.md").read_text(encoding="utf-8")
    space: dict[str, Any] = {}
    exec(re.findall(r"```python\n(.*?)```", page, re.DOTALL)[0], space)
    (square,) = checked((space["GyroSquare"](),), "the page", set(EFFECTS))
    rate = np.array([[1.0, -2.0, 3.0]])
    error = square.error(Reading(Jet(rate), Jet(rate), Jet(np.zeros((1, 1)))), {"square": Jet(SQUARE[None])})
    assert np.array_equal(error.gyro.value, SQUARE * rate * rate)


def test_our_pages_are_not_about_the_effects_of_a_package(package):
    assert "gyro_square" in EFFECTS
    assert "gyro_square" not in effect_table.page() + glossary_page()
    assert "gyro_square" in EFFECTS


def test_an_effect_of_a_package_is_injected_and_drawn_for_datasets(package):
    plain = recorded().imus[1]
    read = injected_samples(plain, [INJECTED], np.random.default_rng(0))
    assert np.allclose(
        read.gyro - plain.gyro, SQUARE * plain.gyro**2, atol=1e-12
    )  # rad/s, of numbers of order 10 in floats
    assert np.array_equal(read.accel, plain.accel)
    (drawn,) = parse_effect({"name": "gyro_square", "at": "imu1"}, "effect[0]").draw(
        np.random.default_rng(0), ("imu1",), 5.0
    )
    assert np.shape(drawn["parameters"]["square"]) == (3,)
    raised = parse_effect({"name": "raised", "height": 0.02}, "effect[0]")
    assert [raised.suits(Shown("hinge", free, encoder=False)) for free in (False, True)] == [True, False]
    rig = rigs.hinge()
    declared = {f"imu{i + 1}": DeclaredMount(m.position, m.quaternion, 1e-3, 5e-3) for i, m in enumerate(rig.mounts)}
    moved = injected_rig(rig, declared, [{"effect": "raised", "at": "imu2", "parameters": {"height": 0.02}}])
    assert np.allclose(moved.mounts[1].position - rig.mounts[1].position, [0.0, 0.0, 0.02])
    assert plays("gyro_square", "free")
    assert plays("raised", "hinge")


@pytest.mark.long
def test_an_effect_of_a_package_is_found_replayed_and_reported(package):
    write_recording(recorded(), package / "recording")
    done = diagnose_on_disk(package / "recording", package / "found")
    first = done.diagnosis.findings[0]
    assert (first.effect, first.at) == ("gyro_square", "imu2")
    said = first.parameters["square"]
    assert np.all(np.abs(said.value - SQUARE) < 4 * said.std)  # one axis in 16,000 is farther off by chance
    page = (package / "found" / "report.html").read_text()
    assert "gyroscope in imu2 that reads a part of its square" in page
    figures = page.split("gyroscope in imu2 that reads a part of its square", 1)[1]
    assert "<svg" in figures
    model = read_model(package / "found" / "model")
    (link,) = [link for link in model.chain("imu2") if link.effect == "gyro_square"]
    truth = truth_of_motion(model.rig, model.motion, model.start, model.end - model.start, RATE)
    stamps = model.imus["imu2"].stamps
    with_it, without = (read_by(truth, model.start, stamps, "imu2", chain)[1] for chain in ((link,), ()))
    assert np.allclose(with_it - without, said.value * without**2, atol=1e-9)  # rad/s, the law of what is played


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ("bad = their_effects:NONE", "expected an Effect or some in their_effects:NONE, got int"),
        ("bad = their_effects:TAKEN", "expected a name that no other effect has, got 'gyro_bias'"),
        ("bad = their_effects:HUM", "expected the numbers amplitude, frequency of gyro_hum, got none"),
        ("bad = their_effects:MISSING", "unknown effect in their_effects 'MISSING'"),
        ("bad = no_such_module:X", "expected an installed module, got none called 'no_such_module'"),
    ],
)
def test_an_effect_that_is_broken_is_left_out_and_said_so(tmp_path, points, message):
    written(tmp_path / "site" / "their_effects.py", THEIRS)
    installed(tmp_path / "site", "their-effects", f"{points}\nsquare = their_effects:SQUARE", "imubench.effects")
    VARIANTS.look_again()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert list(EFFECTS)[-1] == "gyro_square"  # the one beside it is there
    assert any(message in str(w.message) and "from package their-effects 1.2" in str(w.message) for w in said)


def test_effects_are_added_by_hand_and_taken_out(package):
    (square,) = [e for e in VARIANTS if e.name == "gyro_square"]

    class Cube(type(square)):
        name = "gyro_cube"

    VARIANTS.add(Cube())
    try:
        assert list(EFFECTS)[-1] == "gyro_cube"
        with pytest.raises(InputError, match="expected a name that no other effect has, got 'gyro_bias'"):
            VARIANTS.add(EFFECTS["gyro_bias"])
        VARIANTS.take_out("gyro_bias")
        assert "gyro_bias" not in EFFECTS
        assert EFFECTS.name_of(lambda e: e.time_power == 0) == "gyro_bias"  # what it is called stays
    finally:
        VARIANTS.put_back("gyro_cube")
        VARIANTS.put_back("gyro_bias")
    assert next(iter(EFFECTS)) == "gyro_bias"
    assert "gyro_cube" not in EFFECTS

"""Play, backlash and a stop in a free swing that is rolled out, against the independent generator; true numbers."""

import numpy as np

from imubench.correction.sensor_chain import angle_read, at_place, read_by
from imubench.diagnosis.evidence import Swing
from imubench.diagnosis.simulation.splice import rolled_truth
from imubench.proof.frames import LEAD, STEP
from imubench.sim.swing import Start
from tests.concealed import concealed, rms

NOISE = 1.1  # of the noise, as in the table of effects


LET_GO = 0.2  # s behind a window's declared start: a hand lets go a little later than it says


def row_of(found, later=LET_GO):
    """The generator's row so many seconds behind the start of the declared swing."""
    return int(np.ceil((found.recording.free_swings[0][0] + later + LEAD) / STEP))


def rolled(found, seconds, told=True, later=LET_GO):
    """What a roll-out from the true state leaves of imu2's rates and forces, and of the encoder, over their noise."""
    model, world, row = found.model(), found.case.world, row_of(found, later)
    start = float(world.t[row])
    state = Start(angle=float(world.angle[0][row]), angle_rate=float(world.angle[1][row]))
    window = Swing(start, start + seconds, state)
    truth = rolled_truth(model.rig, window, 500.0, model.start, told=model.motion if told else None)
    first, imu, out = start - model.start, found.recording.imus[1], {}
    own = (imu.time > start + 0.01) & (imu.time < window.end - 0.01)  # what is read is interpolated
    _, gyro, accel = read_by(truth, model.start, imu.time[own], "imu2", at_place(model.effects, "imu2"), first=first)
    out["gyro"] = rms((gyro - imu.gyro[own]) / imu.gyro_noise_std)
    out["accel"] = rms((accel - imu.accel[own]) / imu.accel_noise_std)
    for encoder in found.recording.encoders:
        own = (encoder.time > start + 0.01) & (encoder.time < window.end - 0.01)
        read = angle_read(truth, model.start, encoder.time[own], model.effects, first)
        out["encoder"] = rms((read - encoder.angle[own] - encoder.zero) / encoder.angle_noise_std)
    return out


def swung(folder, effect, **options):
    options = {"seconds": 7.0, "swing": True, "base": "fixed"} | options
    return [
        concealed(folder / name, "hinge", [effect], told=told, **options) for name, told in (("a", None), ("b", ()))
    ]


def test_a_limb_turns_in_its_play_as_it_was_recovered(tmp_path):
    """The generator's play swings by a law of its own; nothing foretells the side on which a loose limb lies."""
    effect = ("joint_play", "joint", {"range": 0.03, "direction": 0.7, "kind": "springy"})
    found, without = swung(tmp_path, effect, variant="wobbly")
    left = rolled(found, 3.0)
    assert max(left.values()) < NOISE, left
    lacking = rolled(without, 3.0)
    assert max(lacking.values()) > 10, lacking  # else it showed nothing
    assert max(rolled(found, 3.0, told=False).values()) > 10  # it falls by its law


def test_an_encoder_follows_a_swing_with_free_play(tmp_path):
    found, without = swung(tmp_path, ("backlash", "joint", {"range": 0.03}), encoder=True)
    left = rolled(found, 4.0)
    assert max(left.values()) < NOISE, left
    assert rolled(without, 4.0)["encoder"] > 10


def test_a_swing_goes_to_its_stop_and_back(tmp_path):
    """At the noise from one contact to the next; then nearer than a swing that goes through the stop.

    How stiff it is nobody tells, so a diagnosis rolls out what lies between the contacts (`Stop.swings`).
    """
    found, without = swung(tmp_path, ("end_stop", "joint"))
    stop, angle = float(found.case.effects[0].parameters["angle"]), found.case.world.angle[0]
    beyond = np.sign(stop) * (angle[row_of(found) :] - stop) > 0
    left = int(np.argmax(np.diff(beyond.astype(int)) < 0)) + 20  # rows: the first contact is over
    met = STEP * int(np.argmax(beyond[left:]))
    assert beyond[left:].any() and met > 0.2  # s
    later = LET_GO + STEP * left
    assert max(rolled(found, met - 0.02, later=later).values()) < NOISE
    off = [rolled(case, met + 0.5, later=later)["gyro"] for case in (found, without)]
    assert 10 < off[0] < 0.5 * off[1], off

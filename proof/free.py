"""The free body: one segment that a hand moves and turns at will, usually with its pose measured."""

from imubench.proof.hinge import hand_body
from imubench.proof.motion import random_tempo
from imubench.proof.options import Options, World, stream
from imubench.proof.rotation import Array


def free(options: Options, t: Array, gravity: float, seed: int) -> World:
    """Return a free body's motion under the true `gravity`."""
    tempo = random_tempo(stream(seed, "tempo"), t, options.rest)
    track = hand_body(stream(seed, "motion"), tempo, options, gravity)
    return World(t, [track], (0 * t, 0 * t, 0 * t), [], {"motion": "hand"})

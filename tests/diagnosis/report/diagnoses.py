"""Diagnoses made by hand, what a terminal prints of them, and whether the tags of their page close."""

from dataclasses import replace
from html.parser import HTMLParser

import numpy as np

from imubench.commands.work.diagnose import print_diagnosis
from imubench.diagnosis.evidence import Comparison
from imubench.diagnosis.report.shares import with_shares
from imubench.diagnosis.result import Move, Parameter, SimulatedChannel, Simulation
from imubench.terminal import Terminal
from tests.diagnosis.test_diagnosis_result import TIME, diagnosis, evidence, finding

VOID = {"meta", "br", "img"}


class Balanced(HTMLParser):
    """Collects tags that are not closed, or closed twice, and every attribute that loads something."""

    def __init__(self, text):
        super().__init__()
        self.open, self.wrong, self.loads = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.loads += [v for k, v in attrs if k in ("src", "href", "data", "action")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        pass

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)


def channel(name, before, after, unit="m/s^2", noise=0.03, held=()):
    """A comparison whose models are off by noise-free waves of these amplitudes."""
    wave = np.sin(2 * np.pi * 8 * TIME)
    measured = 3 * np.sin(2 * np.pi * 0.4 * TIME)
    return Comparison(name, unit, TIME, measured, measured + before * wave, measured + after * wave, noise, held)


def simulated(**changes):
    """A diagnosis and its evidence with MuJoCo's simulations: a soft mount, and a bias that is immaterial."""
    held = ((30.0, 60.0),)
    every = (channel("imu2.acc_x", 1.2, 0.02, held=held), channel("imu2.gyr_y", 0.04, 0.002, "rad/s", 0.005, held))
    bias = replace(
        finding("gyro_bias", 0.9, False),
        parameters={"bias": Parameter([0.001, 0.0, 0.002], [0.001] * 3, "rad/s")},
        moves={"orientation": Move([0.1, 0.2], "deg RMS")},
    )
    channels = {
        c.channel: SimulatedChannel(
            c.unit, *(float(np.sqrt(np.mean((y - c.measured) ** 2))) for y in (c.before, c.after)), c.noise
        )
        for c in every
    }
    parts = {
        "findings": (diagnosis().findings[0], bias),
        "simulation": Simulation("prescribed", ((0.0, 60.0),), True, channels),
    }
    shown = replace(evidence(), simulated=every, comparisons=((every[0],), ()))
    return with_shares(diagnosis(**(parts | changes)), shown), shown


def said(d, shown, capsys, paths=None):
    print_diagnosis(d, shown, Terminal(), paths)
    return capsys.readouterr().out

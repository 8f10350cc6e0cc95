"""What `imubench check` reads: claims with the files that their scenarios name, a baseline, runs of a stopped check."""

import json
from pathlib import Path

from fuzz.seeds import laid_out
from imubench.checks.baseline import runs_as_dict
from imubench.checks.claim import load_claims

CLAIMS = b"""
format = 1
estimator = "seel2012"
scenario = "own"
confidence = 0.9
power = 0.9
max_runs = 3

[scenarios.own]
seconds = 2
rate = 50
[[scenarios.own.rig]]
family = "hinge"
[[scenarios.own.motion]]
kind = "random"
[[scenarios.own.imu]]
profile = "own"
file = "profiles.toml"

[claim.axis]
claim = "the axis is right to two degrees"
figure = "best_pairing_rmsae"
at_most = "2 deg"
over = "median"
margin = 0.5
time_limit = 10

[claim.often]
scenario = "hinge-locked"
estimator = "olsson2020"
figure = "maxae"
at_most = "0.1 rad"
at_least = 0.9
broken_at = 0.5
"""
PROFILES = b"""
[own]
summary = "a part of one's own"
rate = { value = 100, unit = "Hz", source = "datasheet" }
[own.gyro]
noise_density = { value = 0.01, unit = "deg/s/sqrt(Hz)", source = "datasheet" }
[own.accel]
noise_std = { value = 2, unit = "mg", source = "datasheet" }
"""


@laid_out
def claims(folder: Path) -> None:
    """Write a file of claims, and the profile that it names."""
    (folder / "claims.toml").write_bytes(CLAIMS)
    (folder / "profiles.toml").write_bytes(PROFILES)


@laid_out
def baseline(folder: Path) -> None:
    """Write claims and an earlier claims.json of theirs."""
    (folder / "claims.toml").write_bytes(CLAIMS)
    (folder / "profiles.toml").write_bytes(PROFILES)
    first, *_ = load_claims(folder / "claims.toml")
    entry = {"name": first.name, "verdict": "holds", **runs_as_dict(first, 0, [0.01, 0.02, float("inf")])}
    (folder / "baseline.json").write_text(json.dumps([entry]), encoding="utf-8")


@laid_out
def runs(folder: Path) -> None:
    """Write the runs that a stopped check had finished."""
    done = {"0": {"figures": {"maxae": 0.01}, "why": ""}, "1": {"figures": {}, "why": "crashed: no"}}
    (folder / "runs.json").write_text(json.dumps(done), encoding="utf-8")

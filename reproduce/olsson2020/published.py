"""The paper's claims, as claims.toml has them."""

from importlib.resources import files

from imubench.reproduce.claims import Claim, load_claims
from imubench.reproduce.olsson2020.measures import MEASURES

CLAIMS = load_claims(files("imubench.reproduce.olsson2020") / "claims.toml", MEASURES)


def claim_measured_by(measure: str) -> Claim:
    """Return the claim that a measure belongs to."""
    return next(c for c in CLAIMS if c.measure == measure)

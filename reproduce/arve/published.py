"""The paper's claims, as claims.toml has them."""

from importlib.resources import files

from imubench.reproduce.arve.measures import MEASURES
from imubench.reproduce.claims import load_claims

CLAIMS = load_claims(files("imubench.reproduce.arve") / "claims.toml", MEASURES)


def published(measure: str) -> float:
    """Return the published number that belongs to a measure."""
    return next(c.published for c in CLAIMS if c.measure == measure)

"""What a dataset is and what made it, in a sentence each."""

from collections.abc import Mapping
from typing import Any

from imubench.dataset.spec import Spec


def described(spec: Spec, manifest: Mapping[str, Any]) -> str:
    """Return in two sentences what a dataset is."""
    total = sum(manifest["recordings"].values())
    what = (
        f"{total:,} simulated IMU recordings of {manifest['rigs']:,} rigs, {manifest['seconds'] / 3600:,.2f} h at "
        f"{spec.rate:g} Hz, with their truth and what their declared models leave out."
    )
    return f"{spec.summary.rstrip('.')}. {what}" if spec.summary else what


def made_with(manifest: Mapping[str, Any]) -> str:
    """Return what determines every byte of a dataset."""
    spec = manifest["spec"]["spec.toml"]
    return f"simulated by imubench {manifest['versions']['imubench']}, seed {manifest['seed']}, spec SHA-256 {spec}"

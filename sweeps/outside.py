"""What tells one version of a sweep's estimators, and of the packages that ours call, from another."""

from collections.abc import Mapping, Sequence

from imubench.plugin_versions import package_version

PEERS = ("qmt", "vqf")  # packages that estimators of our own call where they are installed


def peers() -> dict[str, str]:
    """Return the versions of the packages that estimators of our own may call."""
    return {name: told for name in PEERS if (told := package_version(name))}


def as_table(names: Sequence[str], prints: Mapping[str, str]) -> list[dict[str, str]]:
    """Return estimators and what tells them apart, as the result's file lists them."""
    return [{"estimator": name, "version": prints[name]} for name in names]

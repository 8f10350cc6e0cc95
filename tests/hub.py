"""The Hugging Face `datasets` package without its hub: nothing is sent, and what it caches is gone after the test."""

import datasets
import pytest


@pytest.fixture
def offline(monkeypatch, tmp_path):
    """Return the package, with a cache of its own."""
    monkeypatch.setattr(datasets.config, "HF_HUB_OFFLINE", True)
    monkeypatch.setattr(datasets.config, "HF_DATASETS_CACHE", str(tmp_path / "cache"))
    datasets.disable_progress_bars()
    return datasets

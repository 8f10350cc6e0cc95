"""What the raw samples of a recording say before any fit."""

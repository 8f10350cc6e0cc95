"""Speed and accuracy against named peers, side by side in one run: `make bench` writes RESULTS.md."""

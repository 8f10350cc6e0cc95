"""The sensors' own errors, and those that an undisturbed recording has told beforehand."""

"""Where the fit begins with effects that are far from linear."""

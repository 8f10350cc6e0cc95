"""How large the noise is, what colour it has, and what both do to the fitted numbers."""

"""Which effects the fit needs, and what none of them explains."""

"""Claims about an estimator, decided by as few simulated runs as their confidence needs (docs/your-claim.md)."""

"""Every real recording at hand, diagnosed and held against what is known of it: `make real`, docs/real.md."""

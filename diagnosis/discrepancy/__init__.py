"""Terms without a name: smooth functions of what a recording shows, for what no effect explains."""

"""The least-squares problem: splines, rigs, effects as hypotheses, and the residuals that they make."""

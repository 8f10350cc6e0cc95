"""Garcia de Villa et al., ArVE_d: the synthetic experiments, figures 4 to 9 and table I."""

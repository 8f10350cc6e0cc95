"""Olsson et al., Sensors 20 (2020) 3534: the 14 motions of section 7.1 and the sequences made of them."""

"""What is measured of how a checkout is built, one subject a module; `limits.py` has every measure and its limit.

Its modules import each other by relative names: as a script, `scripts/house.py` finds them beside itself, and the tests
as `scripts.house_measures`.
"""

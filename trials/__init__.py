"""Blind trials: recordings with a sealed truth, a diagnosis that sees the recording alone, and what it was worth.

`make` has the independent generator make recordings and keeps their truths in memory; `seal` publishes a hash of every
truth before the first diagnosis starts; `blind` runs a diagnosis in a process of its own, which `guard` watches;
`match` and `scoring` hold the answer against the opened truth; `figures` counts over all cases; `prove` does it all.
"""

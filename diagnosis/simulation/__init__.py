"""MuJoCo is the judge: the declared model and the model with the findings are played beside the recording.

See docs/simulation-as-judge.md.
"""

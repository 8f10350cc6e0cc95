"""Recordings with a concealed truth, made by code that shares nothing with the testbed it puts on trial.

NumPy and SciPy only, and nothing of `imubench` outside this folder: own kinematics, integrators, effect laws and
writer, written from the words of the interface alone, so that a misreading on either side shows as a disagreement.
`imubench.proof.case.make_case` makes one recording; `imubench.proof.mixture.mixture` draws many.

Everything is computed on one fine grid of time (1 kHz, from before the first sample on), as a chain of moving frames
(`frames.Track`); only at the end the sensors read it on their own clocks. Quaternions are w, x, y, z; world z up.
"""

"""A diagnosis put to use: the corrected recording, and the model that is played again."""

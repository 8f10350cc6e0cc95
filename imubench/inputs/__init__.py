"""The one way in: every file that somebody hands over is read here, bounded before anything is allocated.

Regular files only. A module a kind of file; each raises `InputError`, one line that names the file, where it cannot
be read, is too large (`limits`), or is damaged. What a file says is checked by whoever asked for it.
"""

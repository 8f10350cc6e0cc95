"""Where a recording and its model differ, because of what, and whether the fit improves with it."""

"""Every number that decides something: its value, unit, reason and source, in frozen records by subject."""

"""Which motion would tell effects apart that a recording cannot."""

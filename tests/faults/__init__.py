"""Commands starved, interrupted and misused: a shim that makes their writes fail, and what is looked at afterwards."""

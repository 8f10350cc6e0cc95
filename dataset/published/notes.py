"""What somebody who makes a dataset should know before it is made, or before it is published."""

from imubench.dataset.drawing import first_rigs
from imubench.dataset.shard import Job


def empty_splits(job: Job) -> list[str]:
    """Return a line for each split that has a fraction of the rigs and will have no recording."""
    spec = job.spec
    first = first_rigs(spec, job.seed)
    found = []
    for name, fraction in spec.splits.items():
        begins = first[name] * spec.recordings_per_rig if name in first else None
        if not fraction or (begins is not None and begins < job.count):
            continue
        if begins is None:
            how = "its fraction is too small"
        else:
            how = f"--count {begins + 1} is the least with this seed, or take fewer recordings_per_rig"
        rigs = -(-job.count // spec.recordings_per_rig)
        found.append(f"split '{name}' will be empty: splits go by rig, and there are {rigs}; {how}")
    return found


def before_publishing(job: Job) -> str:
    """Return a line about what README.md and croissant.json lack, which the maker alone can say; empty if nothing."""
    examples = {"licence": 'licence = "CC-BY-4.0"', "published": "published = 2030-01-31"}
    missing = job.spec.terms.missing
    if not missing:
        return ""
    return f"to publish it, say in the spec what only you know: {', '.join(examples[key] for key in missing)}"

"""What of a case its recording's folder holds: nothing in it tells the truth."""

from pathlib import Path
from typing import Any

from imubench.proof.instruments import read_encoder, read_pose, reference
from imubench.proof.mounts import declared
from imubench.proof.played import Case
from imubench.proof.sensors import noise_std
from imubench.proof.write import write_folder


def write(case: Case, out: Path) -> None:
    """Write the recording of a case; nothing in it tells its truth."""
    options, world = case.options, case.world
    top = {"format": 1, "name": options.name, "rig": options.rig, "motion": world.declared["motion"]}
    top |= {"gravity": options.gravity}
    top |= {key: world.declared[key] for key in ("base", "base_quaternion") if key in world.declared}
    tables: dict[str, list[dict[str, Any]]] = {"imu": []}
    for i, (samples, mount, rate) in enumerate(zip(case.imus, case.mounts, case.rates, strict=True)):
        entry: dict[str, Any] = {"name": f"imu{i + 1}", "file": f"imu{i + 1}.csv", "rate": rate}
        if options.declare_noise and options.noise:
            for channel in ("gyro", "accel"):
                usual = noise_std(channel, entry["name"], case.effects, options)[1]
                entry[f"{channel}_noise_std"] = float(f"{usual * (1 + options.misdeclared):.3g}")
        columns = {"time": samples.time}
        for prefix, values in (("gyr", samples.gyro), ("acc", samples.accel)):
            columns |= {f"{prefix}_{axis}": values[:, k] for k, axis in enumerate("xyz")}
        tables["imu"].append(entry | declared(options, mount) | {"columns": columns})
    if options.encoder:
        tables["encoder"] = [_filed("encoder.csv", "joint", read_encoder(world, case.effects, options, case.seed))]
    if options.pose if options.pose is not None else not options.shape.jointed:
        names = [f"segment{i + 1}" for i in range(len(world.segments))]
        poses = [read_pose(track, n, options, case.seed) for track, n in zip(world.segments, names, strict=True)]
        tables["pose"] = [_filed(f"pose{i + 1}.csv", "segment", pose) for i, pose in enumerate(poses)]
    if world.swings:
        tables["free_swing"] = [{"start": start, "end": end} for start, end in world.swings]
    if "body" in world.declared:
        tables["body"] = [dict(world.declared["body"])]
    if options.reference:
        tables["reference"] = [{"file": "reference.csv", "columns": reference(world, options)}]
    write_folder(out, top, tables)


def _filed(file: str, first: str, entry: dict[str, Any]) -> dict[str, Any]:
    return {first: entry[first], "file": file} | entry

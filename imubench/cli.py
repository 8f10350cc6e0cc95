"""The command line: each command writes its result into --out and prints what matters.

Exit codes: 0 done, 1 a limit or claim failed, 2 bad input, 70 an error of ours, 130 and 143 interrupted.
"""

import json
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.table import Table

import imubench
from imubench.cli_claims import check_command
from imubench.errors import InputError
from imubench.estimate import Estimate
from imubench.inputs.files import real
from imubench.progress import on_console
from imubench.terminal import Terminal

app = typer.Typer(
    name="imubench",
    help="A test bench for inertial joint calibration.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
console = Terminal()
errors = Terminal(stderr=True)

Band = Annotated[
    float | None,
    typer.Option("--band", help="Hz: filter the IMUs below it, forward and backward, first.", show_default=False),
]
Out = Annotated[Path | None, typer.Option("--out", help="Folder for the results.", show_default=False)]


@app.callback(invoke_without_command=True)
def version(show: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False) -> None:
    """A test bench for inertial joint calibration."""
    if show:
        console.print(imubench.__version__)
        raise typer.Exit


@app.command("list")
def list_command(as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False, out: Out = None) -> None:
    """List rigs, scenarios, estimators, effects, claims and more, one line each."""
    from imubench.answers import write_json
    from imubench.atomic import atomic_directory
    from imubench.listing import known

    names = known()
    content = {kind: [{"name": n, "summary": s} for n, s in entries.items()] for kind, entries in names.items()}
    if out is not None:
        with atomic_directory(out) as folder:
            write_json(folder / "list.json", content)
    if as_json:
        print(json.dumps(content, indent=2))
        return
    width = max(len(name) for entries in names.values() for name in entries)
    for kind, entries in names.items():
        console.say(kind + ("" if entries else "  (none yet)"), "bold")
        for name, summary in entries.items():
            console.say(f"  {name:<{width}}  {summary}")


@app.command()
def run(
    scenario: Annotated[str, typer.Argument(help="A scenario of `imubench list`, or model/ of a diagnosis.")],
    estimator: Annotated[str | None, typer.Option(help="An estimator of `imubench list`.", show_default=False)] = None,
    seed: Annotated[int, typer.Option(help="The same seed gives the same numbers.", min=0)] = 0,
    band: Band = None,
    on: Annotated[
        Path | None,
        typer.Option(help="A recording: roll a diagnosis' model/ out through its free swings.", show_default=False),
    ] = None,
    out: Out = None,
) -> None:
    """Simulate a scenario, estimate, score, and log it: score.json, recording/, run.rrd.

    The model/ of a diagnosis is played again: rolled out by forces alone inside
    its free swings, elsewhere with the motion that was recovered. With --on it is
    rolled out through the free swings of another recording of the same rig, from
    the state at their starts, beside the model that this recording declares:
    simulation.json says how far each is off, by channel.
    """
    from imubench.answers import pairing_note
    from imubench.run import run_scenario

    if on is not None:
        from imubench.cli_on import run as run_on

        if estimator is not None or band is not None:
            raise InputError("--on: expected it without --estimator and --band, got one of them")
        run_on(Path(scenario), on, out or Path("runs") / f"{Path(scenario).name}-on-{real(on).name}", console, errors)
        return
    out = out or Path("runs") / Path(scenario).name
    done = run_scenario(scenario, out, estimator, seed, on_console(errors), band)
    if done.estimate is None or done.score is None:
        console.say(f"{scenario}: simulated; name an --estimator to estimate and score")
    else:
        title = f"{scenario}, seed {seed}: {done.estimate.estimator} ({done.estimate.status})"
        _print_figures(title, done.score.figures, done.score.units)
        _print_note(pairing_note(done.estimate, done.recording))
        _print_band(done.estimate)
    _print_written(out, "run.rrd")


@app.command()
def estimate(
    name: Annotated[str, typer.Argument(help="An estimator of `imubench list`.")],
    recording: Annotated[Path, typer.Argument(help="A folder in format 1.")],
    diagnosis: Annotated[
        Path | None, typer.Option("--with", help="Take out first what `imubench diagnose` found, from its folder.")
    ] = None,
    band: Band = None,
    out: Out = None,
) -> None:
    """Estimate on a recording from disk, real or not: estimate.json, run.rrd, corrected/ where asked --with."""
    from imubench.answers import pairing_note
    from imubench.run import estimate_on_disk

    out = out or Path("runs") / f"{name}-{real(recording).name}"
    done = estimate_on_disk(name, recording, out, on_console(errors), diagnosis, band)
    for finding in done.done:
        console.say(f"{finding.effect} at {finding.at}: {finding.what}")
    if done.diagnosis is not None and not done.done:
        console.say(f"{done.diagnosis.verdict}: the diagnosis has no findings, nothing is corrected")
    answer = done.estimate
    console.say(f"{done.recording.name}: {name} ({answer.status})", "bold")
    for i, value in enumerate(np.atleast_2d(answer.value if answer.time is None else answer.value[-1])):
        console.say(f"  {done.recording.imus[i].name}: {np.array2string(value, precision=4, floatmode='fixed')}")
    _print_note(pairing_note(answer, done.recording))
    _print_band(answer)
    if done.uncorrected is not None and done.done:
        _print_moved(done.uncorrected, answer, [imu.name for imu in done.recording.imus])
    for beside, what in ((done.beside_reference, "the reference"), (done.beside_declared, "the declared mounts")):
        if beside is not None:
            _print_figures(f"beside {what}", beside.figures, beside.units)
    _print_written(out, "run.rrd")


@app.command()
def convert(
    format: Annotated[str, typer.Argument(help="A format of `imubench list`.")],
    source: Annotated[Path, typer.Argument(help="A file or folder in that format.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the recording, or for one folder each.")],
    option: Annotated[list[str] | None, typer.Option(help="key=value; an unknown key names the known ones.")] = None,
    table: Annotated[str, typer.Option(help="csv or parquet.")] = "csv",
) -> None:
    """Convert a known dataset or file into format 1."""
    from imubench.atomic import atomic_directory
    from imubench.convert import CONVERTERS
    from imubench.errors import unknown
    from imubench.format1 import write_recording
    from imubench.inputs.files import plain_name

    if format not in CONVERTERS:
        raise unknown("format", format, CONVERTERS)
    if table not in ("csv", "parquet"):
        raise unknown("table", table, ("csv", "parquet"))
    converter, options = CONVERTERS[format], _options(option or [])
    inputs = [source, *converter.files(source, options)]
    with on_console(errors)(f"convert {source}"), atomic_directory(out, inputs) as folder:
        converted = converter(source, **options)
        for one in converted:
            name = plain_name(one.recording.name, f"{source}: name of a recording")
            target = folder if len(converted) == 1 else folder / name
            write_recording(one.recording, target, one.reference, table)  # type: ignore[arg-type]
    for one in converted:
        console.say(f"{one.recording.name}: {one.note}")
    _print_written(out)


@app.command("reproduce")
def reproduce_command(
    paper: Annotated[str, typer.Argument(help="A paper, as `imubench list` names it under claims.")],
    quick: Annotated[bool, typer.Option("--quick", help="Fewer runs and starts; under a minute.")] = False,
    seed: Annotated[int, typer.Option(help="The same seed gives the same numbers.", min=0)] = 0,
    out: Out = None,
) -> None:
    """Reproduce every figure, table and claim of a paper: claims.json, report.html.

    Runs on all cores. After Ctrl-C the same command goes on where it was. Exit code 1 when a claim fails.
    """
    from imubench.cli_reproduce import run as run_reproduction

    raise typer.Exit(run_reproduction(paper, out or Path("runs") / paper, quick, seed, console, errors))


@app.command("diagnose")
def diagnose_command(
    recording: Annotated[Path, typer.Argument(help="A folder in format 1.")],
    out: Out = None,
    time_limit: Annotated[
        float, typer.Option("--time-limit", help="Seconds of processor time; then what is known is said.", min=1)
    ] = 600.0,
    tolerance: Annotated[
        str, typer.Option("--tolerance", metavar="DEG,MM", help="What moves less is immaterial and raises no alarm.")
    ] = "0.5,5",
    baseline: Annotated[
        Path | None,
        typer.Option("--baseline", help="An undisturbed recording of the same sensors, or its diagnosis."),
    ] = None,
) -> None:
    """Say where a recording differs from its model, and what physics the model leaves out.

    The motion that explains all sensors best is found from the recording
    alone, played through the declared model, and compared with the samples.
    A reference in the recording never enters that; it only judges.

    Written are diagnosis.json with every number, report.html for people,
    diagnosis.rrd for Rerun, and model/, a simulation with what was found in
    it, which `imubench run DIR/model` replays. Without --out: runs/diagnosis-NAME.

    First the sensors are held against each other: two recordings in one, a
    mirrored or a stuck sensor, swapped files and too few samples are said in
    words, and nothing is fitted. At the time limit the search stops, and the
    verdict is no surer than what was tried.

    Each finding says by how much it moves joint axis, joint centre, hinge
    angle and orientation. What moves none of them by --tolerance is listed
    as immaterial: every sensor has a bias, and a clock that is late by a bit.

    With --baseline the sensors' own errors (bias, scale, misalignment,
    g-sensitivity, noise, rounding, filter) are those of an earlier recording,
    as well as that shows them, and only what is new is found. A recording is
    diagnosed first, into DIR/baseline, in at most half of the time limit.

    Exit code 2 for bad input, with one line about it.
    """
    from imubench.cli_diagnose import run as run_diagnosis

    out = out or Path("runs") / f"diagnosis-{real(recording).name}"
    run_diagnosis(recording, out, time_limit, tolerance, baseline, console, errors)


@app.command("explain")
def explain_command(
    name: Annotated[str, typer.Argument(help="An effect, a figure or a word of a result.")], out: Out = None
) -> None:
    """Explain an effect, a figure or a word in plain words; with --out also as explain.json."""
    from imubench.cli_explain import run as run_explain

    run_explain(name, out, console)


@app.command("prove")
def prove_command(
    cases: Annotated[int, typer.Option(help="How many recordings.", min=1)] = 20,
    seed: Annotated[
        int | None, typer.Option(help="The same seed gives the same cases; none: one that nobody knows.")
    ] = None,
    diagnosis: Annotated[str | None, typer.Option(help="Another diagnosis: words with {recording} and {out}.")] = None,
    seconds: Annotated[float | None, typer.Option(help="Recordings of at most so many seconds.", min=5)] = None,
    timeout: Annotated[float, typer.Option(help="Seconds until a diagnosis is stopped.", min=1)] = 300.0,
    workers: Annotated[int | None, typer.Option(help="Diagnoses at a time; none: one a core.", min=1)] = None,
    baselines: Annotated[bool, typer.Option("--baselines", help="L1 and the oracle on the same cases.")] = False,
    added: Annotated[Path | None, typer.Option(help="Add effects to the real recordings in this folder.")] = None,
    real: Annotated[Path | None, typer.Option(help="Recordings with sealed sidecars in this folder instead.")] = None,
    crime: Annotated[bool, typer.Option("--crime", help="Again with data from the project's own simulator.")] = False,
    leave_one_out: Annotated[bool, typer.Option("--leave-one-out", help="Again without the effect found.")] = False,
    check: Annotated[Path | None, typer.Option(help="Only check the seals of a finished proof in this folder.")] = None,
    seal: Annotated[Path | None, typer.Option(help="Only seal NAME.truth.json beside the recording NAME.")] = None,
    out: Out = None,
) -> None:
    """Blind trials of the diagnosis: proof.json, report.html.

    An independent generator makes recordings with concealed effects. A hash of
    every truth is published before the first diagnosis starts; each diagnosis
    runs in a process that has the recording and nothing else. Then the truths
    are opened, checked against the hashes, and scored.

    After Ctrl-C or a kill the same command goes on where it was. Exit code 1
    when a guard of limits.toml is passed or a diagnosis tried to see more.
    """
    from imubench import cli_prove
    from imubench.trials.settings import Settings

    if check is not None:
        raise typer.Exit(cli_prove.check(check, console))
    if seal is not None:
        raise typer.Exit(cli_prove.seal(seal, console))
    if seed is None:
        seed = 0 if real else cli_prove.new_seed()  # nothing is drawn for recordings that are there
    settings = Settings(cases, seed, timeout=timeout, seconds=seconds)
    settings = replace(
        settings,
        baselines=baselines,
        leave_one_out=leave_one_out,
        added=str(added or ""),
        real=str(real or ""),
        crime=crime,
    )
    if diagnosis is not None:
        settings = replace(settings, command=diagnosis)
    raise typer.Exit(cli_prove.run(settings, out or Path("runs/proof"), workers, console, errors))


@app.command("generate")
def generate_command(
    spec: Annotated[Path, typer.Argument(help="A spec: what rigs, motions, IMUs and effects are drawn from.")],
    count: Annotated[int, typer.Option(help="How many recordings.", min=1, max=2**31 - 1)],
    seed: Annotated[int, typer.Option(help="The same seed gives the same bytes.", min=0, max=2**63 - 1)] = 0,
    workers: Annotated[int | None, typer.Option(help="Processes; none: one a core, 0: only this one.", min=0)] = None,
    engine: Annotated[str, typer.Option(help="Who makes the recordings: local or ray.")] = "local",
    address: Annotated[str | None, typer.Option(help="Of the Ray cluster.", show_default=False)] = None,
    out: Annotated[str | None, typer.Option("--out", help="Folder, or URL, to write.", show_default=False)] = None,
) -> None:
    """Generate a dataset of labelled recordings: Parquet files, manifest.json.

    Any recording follows from the spec, the seed and its number alone. After
    Ctrl-C, a kill or a full disk the same command goes on where it was, to the
    same bytes. Without --out: runs/NAME, by the name in the spec.
    """
    from imubench.cli_generate import run as run_generation

    run_generation(spec, count, seed, out, workers, engine, address, console, errors)


app.command("check")(check_command)


@app.command("verify")
def verify_command(folder: Annotated[str, typer.Argument(help="A dataset of `imubench generate`.")]) -> None:
    """Check every file of a dataset against the hashes in its manifest.json."""
    from imubench.cli_generate import check

    check(folder, console, errors)


@app.command("export")
def export_command(
    form: Annotated[str, typer.Argument(help="qmt, opensim or ring.")],
    folder: Annotated[str, typer.Argument(help="A dataset of `imubench generate`.")],
    out: Annotated[Path, typer.Option("--out", help="Folder for the files.")],
    split: Annotated[str | None, typer.Option(help="Only the recordings of a split.", show_default=False)] = None,
    count: Annotated[int | None, typer.Option(help="At most so many.", min=1, show_default=False)] = None,
) -> None:
    """Export recordings of a dataset to what other tools take: .mat for qmt, .sto for OpenSim, .npz for imt-ring."""
    from imubench.cli_generate import export

    export(form, folder, out, split, count, console, errors)


def _options(pairs: list[str]) -> dict[str, str]:
    options = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        if not equals or not key:
            raise InputError(f"--option: expected key=value, got '{pair}'")
        options[key.replace("-", "_")] = value
    return options


def _print_figures(title: str, figures: dict[str, float], units: dict[str, str]) -> None:
    table = Table(title=title, title_justify="left", box=None, header_style="bold")
    table.add_column("figure")
    table.add_column("value", justify="right")
    table.add_column("unit")
    shown = {"rad": (180 / np.pi, "deg"), "m": (1e3, "mm")}
    for name, value in figures.items():
        factor, unit = shown.get(units[name], (1.0, units[name]))
        table.add_row(name, f"{value * factor:.3f}", unit)
    console.print(table)


def _print_note(note: str) -> None:
    if note:
        console.say(f"  {note}")


def _print_moved(before: Estimate, answer: Estimate, names: list[str]) -> None:
    """Print by how much an estimate differs from that of the recording as it came."""
    from imubench.answers import moved

    if (by := moved(before, answer)) is None:
        return
    told = ", ".join(f"{name} {value:.2f} {by[1]}" for name, value in zip(names, by[0], strict=True))
    console.say(f"  moved by what was taken out: {told} (as it came: {before.status})")


def _print_band(answer: Estimate) -> None:
    """Print in words which band an estimate is from, if it is from one."""
    from imubench.estimators.banded import explained

    words = explained(answer)
    if words:
        console.say(words)


def _print_written(out: Path, rrd: str | None = None) -> None:
    console.say(f"written: {out}" + (f"; look at it with: rerun {out / rrd}" if rrd else ""))

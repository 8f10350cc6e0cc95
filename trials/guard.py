"""What a diagnosis on trial may touch: the process that runs it, watched through Python's audit events.

    python -m imubench.trials.guard ROOM LEFT_OUT PROGRAM ARGUMENTS ...

PROGRAM is a module or a .py file. It may read the working folder ROOM and what the interpreter and its packages are
made of, and write into ROOM alone. Everything else is refused and noted in ROOM/refused.txt: other files and folders,
new processes, connections, the generator's and the trials' code. LEFT_OUT is an effect taken out of the library, or -.
Audit events see Python; code in C is held by the namespaces that `blind` adds where the system has them.
"""

import os
import runpy
import sys
from pathlib import Path

NOTE = "refused.txt"
SYSTEM = ("/usr", "/lib", "/lib64", "/bin", "/etc", "/sys", "/opt/hostedtoolcache", "/System", "/Library")
DEVICES = ("/dev/null", "/dev/urandom", "/dev/random", "/dev/shm", "/dev/tty")
PROCESSES = ("subprocess.Popen", "os.exec", "os.posix_spawn", "os.system", "os.fork", "os.forkpty", "os.startfile")
SECRET = ("imubench.proof", "imubench.trials")
WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def watch(room: Path) -> None:
    """Refuse from now on, in this process, what a diagnosis has no business with."""
    home = os.path.realpath(room)
    readable = tuple(dict.fromkeys(os.path.realpath(p) for p in (*_code(), __file__, *SYSTEM)))
    note = os.open(room / NOTE, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o600)

    def inside(path: str, folders: tuple[str, ...]) -> bool:
        return any(path == folder or path.startswith(folder + os.sep) for folder in folders)

    def refuse(what: str) -> None:
        os.write(note, f"{what}\n".encode(errors="replace"))
        raise PermissionError(f"refused to a diagnosis on trial: {what}")

    def path_allowed(path: object, writes: bool) -> bool:
        if path is None or isinstance(path, int):
            return True
        full = os.path.realpath(os.fsdecode(path))  # type: ignore[arg-type]
        if inside(full, (home,)) or inside(full, DEVICES):
            return True
        if full.startswith("/proc/"):
            process = full.split("/")[2]
            return not writes and (not process.isdigit() or int(process) == os.getpid())
        return not writes and (inside(full, readable) or not os.path.exists(full))  # noqa: PTH110  # nothing to learn

    def hook(event: str, args: tuple[object, ...]) -> None:
        if event == "open":
            path, mode, flags = args
            writes = bool(int(flags or 0) & WRITES) or any(c in str(mode or "") for c in "wax+")  # type: ignore[call-overload]
            if not path_allowed(path, writes):
                refuse(f"{'write' if writes else 'read'} {path!r}")
        elif event in ("os.listdir", "os.scandir"):
            if not path_allowed(args[0] if args[0] is not None else ".", False):
                refuse(f"list {args[0]!r}")
        elif event in PROCESSES:
            refuse(f"start {args[0] if args else ''!r}")
        elif event == "socket.connect":
            refuse(f"connect {args[1]!r}")
        elif event == "import" and str(args[0]).startswith(SECRET):
            refuse(f"import {args[0]}")

    sys.addaudithook(hook)


def _code() -> list[str]:
    """Return the folders that the interpreter and the packages are made of."""
    import imubench

    found = [sys.prefix, sys.base_prefix, *(p for p in sys.path if p and os.path.isdir(p))]  # noqa: PTH112
    found += list(imubench.__path__)
    for finder in sys.meta_path:  # an editable install maps packages to folders
        mapping = getattr(sys.modules.get(getattr(finder, "__module__", "")), "MAPPING", {})
        found += [folder for name, folder in mapping.items() if not name.startswith(SECRET)]
    return found


def main(room: str, left_out: str, program: str, *arguments: str) -> None:
    """Run a program under watch."""
    if left_out != "-":
        take_out(left_out)
    for name in [name for name in sys.modules if name.startswith(SECRET)]:
        del sys.modules[name]
    sys.argv = [program, *arguments]
    watch(Path(room))
    if program.endswith(".py"):
        runpy.run_path(program, run_name="__main__")
    else:
        runpy.run_module(program, run_name="__main__", alter_sys=True)


def take_out(name: str) -> None:
    """Take every variant of an effect out of the library of this process."""
    from imubench import effects

    effects.VARIANTS.take_out(name)


if __name__ == "__main__":
    main(*sys.argv[1:])

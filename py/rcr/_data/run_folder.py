"""A folder of results belongs to one run: run.json records the run, a lock excludes others.

run.json holds `program`, `run`, `parameters`, `version`, `commit` and `date`. A resumed run adds
`continued`, the versions, commits and dates of its continuations. `run` is a short hash of the
parameters that determine the results. The run's files carry the hash, so that readers detect files
of different runs in one folder.

Needs Python alone.
"""

import contextlib
import datetime
import functools
import hashlib
import json
import os
import pathlib
import subprocess

from rcr._data import files

RUN, LOCK = "run.json", ".lock"


def identity(parameters):
    """Return a short hash of parameters; equal parameters have equal hashes."""
    text = json.dumps(parameters, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


@functools.cache
def commit():
    """Return the commit of the clone, with a + for changed files, or 'unknown' outside a clone."""
    if stated := os.environ.get("YADE_RCR_COMMIT"):
        return stated
    clone = pathlib.Path(__file__).resolve().parents[3]
    if not (clone / ".git").exists():  # an installed package may lie in another repository
        return "unknown"
    describe = ["git", "-C", clone, "describe", "--always", "--dirty=+", "--abbrev=12",
                "--exclude=*"]
    with contextlib.suppress(OSError):
        done = subprocess.run(describe, capture_output=True, text=True)
        return done.stdout.strip() or "unknown"
    return "unknown"


def read(folder):
    """Return the contents of a folder's run.json, None if there is none."""
    path = pathlib.Path(folder) / RUN
    return files.read_json(path, "a run.json", program=str, run=str, parameters=dict)


@contextlib.contextmanager
def claim_folder(
    folder, program, parameters, made, free=(), checkpoint=None, last=None, resume=False,
    overwrite=False, wait=False,
):  # fmt: skip
    """Block in which the folder, made if missing, belongs to this process. It yields `begin`.

    `begin()` removes the files of the previous run (of a resumed run only `last`), writes run.json
    and returns its contents. Call it after everything that can fail early. A ValueError says that
    the folder holds another run, or that another process has it.

    `program` is the name of the script, `parameters` are those of the run, as JSON values; `resume`
    continues the run in the folder and may change those named in `free`. `made` are patterns of the
    program's files. `checkpoint` and `last` are the file from which `resume` continues and the last
    file of a complete run. `overwrite` removes a run of other parameters, or one with a checkpoint.
    `wait` waits for another process that has the folder.
    """
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with lock_folder(folder, wait=wait):
        files.remove_parts(folder)
        kept = read(folder)
        old = [path for pattern in made for path in sorted(folder.glob(pattern))]
        if kept is not None and kept["program"] != program:
            raise ValueError(f"{folder} holds results of {kept['program']}; choose another --out")
        other = resume and kept and differing(kept["parameters"], parameters, free)
        if other:
            todo = "give its options, or start again with --overwrite"
            raise ValueError(f"--resume: the run in {folder} has {other}; {todo}")
        if not (resume or overwrite):
            _check_new(folder, kept, old, parameters, checkpoint, last)

        def begin():
            record = _record(program, parameters, free, kept if resume else None)
            for path in old:
                if not resume or path.name == last:
                    path.unlink()
            files.write(folder / RUN, json.dumps(record, indent=2, ensure_ascii=False) + "\n")
            return record

        yield begin


@contextlib.contextmanager
def lock_folder(folder, name=LOCK, wait=False):
    """Block that excludes other processes from the folder's lock `name`.

    The lock ends with the process. Without `wait`, a lock of another process raises a ValueError.
    """
    path = pathlib.Path(folder) / name
    try:
        lock = files.locked(path, wait)
    except BlockingIOError:
        message = "another process is writing there; wait for it or choose another --out"
        raise ValueError(f"{folder}: {message}") from None
    with lock:
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def differing(one, other, free=()):
    """Return the parameters that differ, with both values, as text; '' if none differs."""
    return ", ".join(f"{name} = {_short(one.get(name))} (here {_short(other.get(name))})"
                     for name in dict.fromkeys([*one, *other])
                     if name not in free and one.get(name) != other.get(name))


def _record(program, parameters, free, kept):
    """Return the contents of run.json: of a new run, or of the continuation of the run `kept`."""
    from rcr import __version__

    date = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
    now = dict(version=__version__, commit=commit(), date=date)
    if kept:
        return dict(kept, parameters=parameters, continued=[*kept.get("continued", ()), now])
    fixed = {name: value for name, value in parameters.items() if name not in free}
    return dict(program=program, run=identity(fixed), parameters=parameters, **now)


def _short(value):
    text = str(value)
    return text if len(text) <= 80 else f"{text[:79]}…"


def _check_new(folder, kept, old, parameters, checkpoint, last):
    """Raise a ValueError if the folder holds files that a new run would remove."""
    todo = "choose another --out, or remove it with --overwrite"
    if old and kept is None:
        names = ", ".join(path.name for path in old[:3]) + (", …" if len(old) > 3 else "")
        raise ValueError(f"{folder} holds {names} of an unknown run; {todo}")
    other = old and differing(kept["parameters"], parameters)
    if other:
        raise ValueError(f"{folder} holds a run with {other}; {todo}")
    todo = "continue it with --resume, or start again with --overwrite"
    for name, state in ((last, "complete"), (checkpoint, "not complete")):
        if checkpoint and (folder / name).exists():
            raise ValueError(f"{folder} holds this run, {state}; {todo}")

"""A folder of results and the run that owns it: run.json, and a lock that ends with its process. Needs Python alone.

run.json holds `program`, `run`, `parameters`, `version`, `commit`, `date` and, of a run that was resumed, `continued`: versions,
commits and dates. `run` is a short hash of the parameters that set the results; files of the run carry it too, so that a reader
can tell a mixture.
"""

import contextlib
import datetime
import functools
import hashlib
import json
import os
import pathlib
import shutil
import subprocess

from rcr import _files as files

RUN, LOCK = "run.json", ".lock"


def identity(parameters):
    """Short hash of parameters: equal where they are."""
    text = json.dumps(parameters, sort_keys=True, allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


@functools.cache
def commit():
    """Commit of the clone that the package lies in, with a + if files differ from it; 'unknown' outside of a clone."""
    stated = os.environ.get("YADE_RCR_COMMIT")
    if stated:
        return stated
    here = os.path.dirname(os.path.realpath(__file__))
    command = ["git", "-C", here, "describe", "--always", "--dirty=+", "--abbrev=12", "--exclude=*"]
    with contextlib.suppress(OSError):
        return subprocess.run(command, capture_output=True, text=True).stdout.strip() or "unknown"
    return "unknown"


def read(folder):
    """Contents of run.json of a folder, None if there is none.

    Raises
    ------
    ValueError
        If it is damaged.
    """
    path = pathlib.Path(folder) / RUN
    if not path.exists():
        return None
    with files.reading(path, "a run.json"):
        found = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(found, dict) or not isinstance(found.get("parameters"), dict) or not all(isinstance(found.get(name), str) for name in ("program", "run")):
            raise ValueError("lacks program, run or parameters")
        return found


@contextlib.contextmanager
def claim_folder(folder, program, parameters, made, free=(), checkpoint=None, last=None, resume=False, overwrite=False, wait=False):
    """Block in which the folder, made if missing, belongs to this process. The block yields `begin`, which makes the folder this run's.

    `begin()` removes the files of the run before, unless it is resumed, writes run.json and returns what that holds: to be called when
    what could fail before has not.

    Parameters
    ----------
    folder : path
    program : str
        Name of the script.
    parameters : dict
        What the run is of, in values of JSON.
    made : list of str
        Patterns of the files that the program leaves; a new run removes those of the run before.
    free : list of str
        Names of parameters that do not change what another run with the others gives, up to where both go: `resume` may change them.
    checkpoint, last : str
        Names of the file that `resume` goes on from and of the one that a complete run writes last.
    resume : bool
        Go on with the run that is there.
    overwrite : bool
        Remove a run of other parameters, or one that has a checkpoint.
    wait : bool
        For another process that has the folder, instead of a refusal.

    Raises
    ------
    ValueError
        If another run is there or is being made, and what to do.
    OSError
        If the folder cannot be written.
    """
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    with lock_folder(folder, wait=wait):
        _remove_parts(folder)
        kept = read(folder)
        old = [path for pattern in made for path in sorted(folder.glob(pattern))]
        if kept is not None and kept["program"] != program:
            raise ValueError(f"{folder} holds results of {kept['program']}; wanted another --out")
        if resume:
            _check_resumable(folder, kept, parameters, free)
        elif not overwrite:
            _check_new(folder, kept, old, parameters)
            if checkpoint and (folder / last).exists():
                raise ValueError(f"{folder} holds this run, complete; --resume goes on with it, --overwrite makes it anew")
            if checkpoint and (folder / checkpoint).exists():
                raise ValueError(f"{folder} holds this run, not complete; --resume goes on with it, --overwrite starts anew")
        own = dict(program=program, run=identity({name: value for name, value in parameters.items() if name not in free}), parameters=parameters)

        def begin():
            now = dict(version=_version(), commit=commit(), date=datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"))
            record = dict(own, **now)
            if resume and kept:
                record = dict(kept, parameters=parameters, continued=[*kept.get("continued", ()), now])
            for path in [] if resume else old:
                path.unlink()
            files.write(folder / RUN, json.dumps(record, indent=2, ensure_ascii=False) + "\n")
            return record

        yield begin


@contextlib.contextmanager
def lock_folder(folder, name=LOCK, wait=False):
    """Block in which no other process is in its block for the folder and the name; the lock ends with the process.

    Raises
    ------
    ValueError
        If another one is, and this one is not to wait.
    """
    path = pathlib.Path(folder) / name
    try:
        lock = files.locked(path, wait)
    except BlockingIOError:
        raise ValueError(f"{folder}: another process is writing there; wait for it or choose another --out") from None
    with lock:
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def differing(one, other, free=()):
    """Names of the parameters that differ, with both values in words; '' if none does."""
    names = [name for name in dict.fromkeys([*one, *other]) if name not in free and one.get(name) != other.get(name)]
    return ", ".join(f"{name} = {_short(one.get(name))} (here {_short(other.get(name))})" for name in names)


def _short(value):
    text = str(value)
    return text if len(text) <= 80 else f"{text[:79]}…"


def _remove_parts(folder):
    """Half-written files of killed processes; those that another process is writing stay."""
    for partial in folder.glob(files.PART + "*"):
        if partial.is_dir():
            shutil.rmtree(partial)
            continue
        with contextlib.suppress(BlockingIOError), files.locked(partial, wait=False):
            partial.unlink()


def _check_resumable(folder, kept, parameters, free):
    other = kept and differing(kept["parameters"], parameters, free)
    if other:
        raise ValueError(f"--resume: the run in {folder} has {other}; give its options, or start anew with --overwrite")


def _check_new(folder, kept, old, parameters):
    if not old:
        return
    if kept is None:
        names = ", ".join(path.name for path in old[:3]) + (", …" if len(old) > 3 else "")
        raise ValueError(f"{folder} holds {names} of an unknown run; wanted another --out, or --overwrite, which removes them")
    other = differing(kept["parameters"], parameters)
    if other:
        raise ValueError(f"{folder} holds a run with {other}; wanted another --out, or --overwrite, which removes it")


def _version():
    from rcr import __version__

    return __version__

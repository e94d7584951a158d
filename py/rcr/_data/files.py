"""Atomic writes, and readers that report damaged files. Needs Python alone; HDF5 needs h5py.

A file is written to a temporary name, flushed to the disk and renamed. A crash or a full disk
leaves the previous file unchanged. HDF5 files are built in memory, because the HDF5 library ends
the process when a write fails.
"""

import contextlib
import csv
import fcntl
import hashlib
import io
import json
import os
import pathlib
import shutil
import stat

PART = ".part-"  # prefix of files that are being written
SEAL = b"\nrcr sha256 "  # precedes the 64 digits at the end of an HDF5 file, which HDF5 ignores
LARGEST_RATIO = 1100  # largest ratio of unpacked to packed size [-]; deflate reaches 1032


def write(path, content):
    """Write bytes or text (as UTF-8) to a file by `atomic_path`; an OSError names the path."""
    try:
        with atomic_path(path) as partial, open(partial, "wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error


@contextlib.contextmanager
def atomic_path(path):
    """Yield a temporary path to write to; flush the file and rename it to `path` at the end.

    The temporary file is beside `path`, has its suffix, and is locked. An exception removes it. The
    file gets the permissions of the umask. A symbolic link keeps its target.
    """
    check_writable(path)
    target = os.path.realpath(os.fsdecode(path))
    folder, name = os.path.split(target)
    partial = os.path.join(folder, PART + os.fsdecode(os.fsencode(name)[-200:]))
    with locked(partial):
        try:
            yield partial
            _flush(partial)
            os.replace(partial, target)
        except BaseException:
            with contextlib.suppress(FileNotFoundError):
                os.unlink(partial)
            raise
    _flush(folder)


def remove_parts(folder):
    """Remove the partial files of killed processes; running processes keep theirs."""
    for path in pathlib.Path(folder).glob(PART + "*"):
        with contextlib.suppress(BlockingIOError, FileNotFoundError):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                with locked(path, wait=False):
                    path.unlink()


def check_writable(path):
    """Raise an OSError if no file can be written at `path`; call it before a long computation."""
    path = os.path.realpath(path_of("the path of a file", path))
    folder = os.path.dirname(path)
    if os.path.isdir(path):
        raise IsADirectoryError(21, "is a folder; expected the name of a file", path)
    if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
        message = "is not a regular file; expected the name of a new or a regular file"
        raise OSError(22, message, path)
    if not os.path.isdir(folder):
        raise FileNotFoundError(2, "this folder does not exist", folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(13, "this folder cannot be written", folder)


def locked(path, wait=True):
    """Open a file for appending, make it if missing, and lock it until it is closed.

    Without `wait`, the lock of another process raises a BlockingIOError.
    """
    while True:
        file = open(path, "ab")
        try:
            fcntl.flock(file, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
            if os.path.samestat(os.fstat(file.fileno()), os.stat(path)):
                return file
        except FileNotFoundError:
            pass
        except BaseException:
            file.close()
            raise
        file.close()  # another process has renamed or removed the file: open it again


def _flush(path):
    """Flush a file, or the names in a folder, to the disk."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def hdf5(fill):
    """Return the bytes of a sealed HDF5 file, filled by `fill(file)`; a change removes the seal."""
    import h5py

    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        fill(file)
    content = image.getvalue()
    return content + SEAL + hashlib.sha256(content).hexdigest().encode()


def table(columns, rows):
    """Return rows (dicts) as CSV text. A missing value is empty; other keys are ignored."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


def read_table(path, columns):
    """Return the rows of a CSV file with these columns as dicts of text, within `reading`."""
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file, strict=True)
        missing = [name for name in columns if name not in (reader.fieldnames or ())]
        if missing:
            raise ValueError(f"lacks the column {' and '.join(missing)}")
        return list(reader)


@contextlib.contextmanager
def reading(path, kind):
    """Block that reads the file `path`; every error of a damaged file becomes one ValueError.

    `kind` is the expected kind of file, for the message. An OSError says that the file is missing,
    is a folder or is not readable.
    """
    if stat.S_ISFIFO(os.stat(path_of("the path of a file", path)).st_mode):
        raise OSError(22, "is a pipe; expected a file", os.fspath(path))
    with open(path, "rb"):
        pass
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{path}: {one_line(error)}") from error
    except MemoryError as error:
        raise ValueError(f"{path}: damaged, or larger than the memory") from error
    except Exception as error:  # zlib.error, BadZipFile, EOFError, KeyError, RuntimeError …
        raise ValueError(f"{path}: damaged, or not {kind} ({one_line(error)})") from error


def read_json(path, kind, **members):
    """Return the dict of a JSON file, None if it is missing; `members` are types by their names.

    A damaged file raises a ValueError.
    """
    if not os.path.exists(path):
        return None
    with reading(path, kind), open(path, encoding="utf-8") as file:
        found = json.load(file)
        if not isinstance(found, dict):
            raise ValueError("holds no keys")
        missing = [name for name, type_ in members.items()
                   if not isinstance(found.get(name), type_)]
        if missing:
            raise ValueError(f"lacks {', '.join(missing)}")
        return found


def open_hdf5(path):
    """Open an HDF5 file for reading; a ValueError if it is sealed and damaged.

    HDF5 itself can miss damage or hang. Its lock is off: files are whole once they have their name,
    and it would reject a file whose writer has not yet released the lock of `atomic_path`.
    """
    import h5py

    with open(path, "rb") as file:
        content = file.read()
    digest = hashlib.sha256(content[:-76]).hexdigest().encode()
    if content[-76:-64] == SEAL and content[-64:] != digest:
        raise ValueError("damaged: its check sum is wrong")
    return h5py.File(path, "r", locking=False)


def check_size(name, size, path):
    """Raise a ValueError if `size` unpacked bytes cannot come from this file."""
    if size > LARGEST_RATIO * (os.path.getsize(path) + 1024):
        raise ValueError(f"{name} has {size} bytes, more than the file can hold: it is damaged")


def path_of(name, value):
    """Return `value` as a path, or raise a ValueError."""
    if isinstance(value, (str, bytes, os.PathLike)):
        path = os.fsdecode(value)
        if path and "\0" not in path:
            return path
    raise ValueError(f"{name} = {value!r}; expected a path")


def one_line(error):
    """Return the message of an error on one line; its type if it has no message."""
    if isinstance(error, OSError) and error.strerror:
        name = error.filename
        prefix = "" if name is None else f"{name if isinstance(name, int) else os.fsdecode(name)}: "
        return prefix + " ".join(error.strerror.split())
    return " ".join(str(error).split())[:500] or type(error).__name__


def jsonable(item):
    """Return arrays as lists and numbers that are not finite as None, for strict JSON."""
    text = json.dumps(item, default=lambda array: array.tolist())
    return json.loads(text, parse_constant=lambda name: None)

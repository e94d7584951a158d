"""Files that are whole or not there, and readers that name a damaged file. Needs Python alone, h5py for HDF5.

A file is made in memory, written beside its place, flushed to the disk and renamed: whenever the process is killed or the disk is
full, the file of before stands as it was. HDF5 is made in memory too, since its library ends the process when a write fails.
"""

import contextlib
import csv
import fcntl
import hashlib
import io
import os
import stat
import tempfile

PART = ".part-"  # begins the name of a file that is being written
SEAL = b"\nrcr sha256 "  # ends an HDF5 file of ours, with the 64 digits of the rest; HDF5 ignores what follows its own end
LARGEST_RATIO = 1100  # of the size of unpacked data over that of the file: deflate reaches 1032


def write(path, content):
    """Write a file, whole or not at all.

    Parameters
    ----------
    path : path
        Replaced if it exists; behind a symbolic link, the file that it points to.
    content : bytes or str
        Text is encoded as UTF-8.

    Raises
    ------
    OSError
        If it cannot be written, with the path; what was there before is there still.
    """
    check_writable(path)
    target = os.path.realpath(path)
    partial = _beside(target)
    try:
        with locked(partial) as file:
            try:
                file.truncate(0)
                file.write(content.encode() if isinstance(content, str) else content)
                file.flush()
                os.fsync(file.fileno())
                os.replace(partial, target)
            except BaseException:
                os.unlink(partial)
                raise
        _flush(os.path.dirname(target))
    except OSError as error:
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error


@contextlib.contextmanager
def atomic_path(path):
    """Path to write to in the place of `path`: a file of the same name, which takes its place when the block ends well.

    For libraries that write to a name. The file lies in a hidden folder beside `path` until then, and nothing is left of it when the
    block fails. The file has the permissions of any file that the user makes.

    Raises
    ------
    OSError
        If the folder does not exist or cannot be written to.
    """
    check_writable(path)
    folder, name = os.path.split(os.path.realpath(path))
    with tempfile.TemporaryDirectory(prefix=PART, dir=folder) as hidden:
        partial = os.path.join(hidden, name)
        yield partial
        _flush(partial)
        os.replace(partial, os.path.join(folder, name))
        _flush(folder)


def check_writable(path):
    """OSError if no file can be written at `path`: to be asked before a long computation of what goes there."""
    path = os.path.realpath(path_of("the path of a file", path))
    folder = os.path.dirname(path)
    if os.path.isdir(path):
        raise IsADirectoryError(21, "is a folder; wanted the name of a file", path)
    if os.path.exists(path) and not stat.S_ISREG(os.stat(path).st_mode):
        raise OSError(22, "is no regular file; wanted the name of a new or a regular one", path)
    if not os.path.isdir(folder):
        raise FileNotFoundError(2, "there is no such folder", folder)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(13, "this folder cannot be written", folder)


def _beside(target):
    """Where it is written first; a name too long for that is cut."""
    folder, name = os.path.split(target)
    return os.path.join(folder, PART + os.fsdecode(os.fsencode(name)[-200:]))


def locked(path, wait=True):
    """The file `path` open for appending, made if missing, and locked until it is closed or the process ends.

    Raises
    ------
    BlockingIOError
        If another process has the lock and this one is not to wait.
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
        file.close()  # the other process has renamed or removed it meanwhile


def _flush(path):
    """A file, or the names in a folder, survive a loss of power from here on."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def hdf5(fill):
    """Bytes of an HDF5 file, sealed; `fill(file)` puts its contents in. A program that changes the file takes the seal off."""
    import h5py

    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        fill(file)
    content = image.getvalue()
    return content + SEAL + hashlib.sha256(content).hexdigest().encode()


def table(columns, rows):
    """Text of a CSV file of rows (dicts); columns that a row lacks stay empty, keys that are no column are left out."""
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()


# ---------------------------------------------------------------------------------------------- reading


@contextlib.contextmanager
def reading(path, kind):
    """Block that reads the file `path`: whatever is thrown at a damaged one ends as one ValueError of one line.

    Parameters
    ----------
    path : path
    kind : str
        What was expected, for the message.

    Raises
    ------
    ValueError
        With the path and what is wrong.
    OSError
        If the file is missing, is a folder or may not be read.
    """
    if stat.S_ISFIFO(os.stat(path_of("the path of a file", path)).st_mode):
        raise OSError(22, "is a pipe; wanted a file", os.fspath(path))
    with open(path, "rb"):
        pass
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{path}: {one_line(error)}") from error
    except MemoryError as error:
        raise ValueError(f"{path}: damaged, or more than the memory holds") from error
    except Exception as error:  # libraries meet damaged bytes in many ways: zlib.error, BadZipFile, EOFError, KeyError, RuntimeError …
        raise ValueError(f"{path}: damaged, or not {kind} ({one_line(error)})") from error


def check_seal(path):
    """ValueError if a sealed file is damaged. HDF5 would find most of that, but not all, and not always come to an end."""
    with open(path, "rb") as file:
        content = file.read()
    if content[-76:-64] == SEAL and content[-64:] != hashlib.sha256(content[:-76]).hexdigest().encode():
        raise ValueError("damaged: its content is not what was written")


def check_size(name, size, path):
    """ValueError if `size` bytes are more than a file of this length can hold, packed: of a damaged header."""
    if size > LARGEST_RATIO * (os.path.getsize(path) + 1024):
        raise ValueError(f"{name} is said to hold {size} bytes, more than the file can: it is damaged")


def path_of(name, value):
    """`value` as a path, ValueError if it is none."""
    if not isinstance(value, (str, bytes, os.PathLike)) or not os.fspath(value) or "\0" in os.fsdecode(value):
        raise ValueError(f"{name} = {value!r}; wanted a path")
    return os.fsdecode(value)


def one_line(error):
    """Message of an error on one line; its type where it has none."""
    if isinstance(error, OSError) and error.strerror:
        name = "" if error.filename is None else f"{os.fsdecode(error.filename) if not isinstance(error.filename, int) else error.filename}: "
        return name + " ".join(error.strerror.split())
    return " ".join(str(error).split())[:500] or type(error).__name__

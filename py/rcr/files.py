"""Files that are written whole or not at all."""

import contextlib
import os
import tempfile


@contextlib.contextmanager
def whole(path):
    """Path to write to in the place of `path`: a file of the same name, which takes its place when the block ends well.

    It lies in a hidden folder beside it until then, and nothing is left of it when the block fails. The file has the permissions of
    any file that the user makes.

    Raises
    ------
    OSError
        If the folder does not exist or cannot be written to.
    """
    folder, name = os.path.split(os.path.abspath(path))
    with tempfile.TemporaryDirectory(prefix=".rcr-", dir=folder) as hidden:
        partial = os.path.join(hidden, name)
        yield partial
        os.replace(partial, path)

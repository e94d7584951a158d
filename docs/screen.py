"""A screen without a monitor, with OpenGL in software, for YADE's 3D view. Needs Xvfb."""

import contextlib
import os
import subprocess


@contextlib.contextmanager
def virtual_screen(folder, size="1024x768"):
    """The environment in which a program shows its windows on a screen of its own, for as long as the context lasts.

    Parameters
    ----------
    folder : path
        For the files that the program wants for the session.
    size : str
        Width and height of the screen [pixels].

    Yields
    ------
    dict
        To be given to a process as its environment.
    """
    reading, writing = os.pipe()
    screen = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", f"{size}x24", "-nolisten", "tcp"], pass_fds=[writing],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    os.close(writing)
    try:
        with os.fdopen(reading) as number:
            display = ":" + number.readline().strip()
        yield os.environ | {"DISPLAY": display, "LIBGL_ALWAYS_SOFTWARE": "1", "QT_X11_NO_MITSHM": "1", "XDG_RUNTIME_DIR": str(folder)}
    finally:
        screen.terminate()
        screen.wait()

"""A virtual screen with OpenGL in software, for YADE's 3D view. Needs Xvfb."""

import contextlib
import os
import subprocess


@contextlib.contextmanager
def virtual_screen(folder):
    """Start a virtual screen; yields the environment of programs that use it.

    `folder` holds the session files of these programs.
    """
    reading, writing = os.pipe()
    command = ["Xvfb", "-displayfd", str(writing), "-screen", "0", "1024x768x24", "-nolisten", "tcp"]
    screen = subprocess.Popen(command, pass_fds=[writing], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        with os.fdopen(reading) as number:
            display = ":" + number.readline().strip()
        yield os.environ | dict(DISPLAY=display, LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1",
                                XDG_RUNTIME_DIR=str(folder))
    finally:
        screen.terminate()
        screen.wait()

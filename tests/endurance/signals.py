#!/usr/bin/env python3
"""Signals to the scripts of a clone: results are written, exit codes and resumed results are right.

    python3 tests/endurance/signals.py FOLDER [YADE]

It needs Python alone. Outside the environment of the project each command enters it, see
scripts/lib/environment.sh; `scripts/check signals` does this. tests/yade/run/test_signals.py calls
the functions inside. With YADE, a command such as `yade` with the Debian package, only scenes run;
scripts/lib/try-deb does this.
"""

import contextlib
import os
import pathlib
import shlex
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ROOT / "scripts"
YADE = [str(SCRIPTS / "yade-rcr"), "-n", "-x"]
PATIENCE = 300  # only a hang takes them [s]
SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP

SCENE = """
import os
import rcr
from rcr import *
O.bodies.append(particle((0, 0), 0.1, 0.5, velocity=(1, 0)))
O.engines = [ForceResetter(), InsertionSortCollider([Bo1_Rcr_Aabb()]),
             InteractionLoop([Ig2_Rcr_Rcr_RcrGeom()], [Ip2_FrictMat_FrictMat_CdPhys()],
                             [Law2_RcrGeom_CdPhys_SignoriniCoulomb()]),
             ContactDynamics(), NewtonIntegrator(damping=0),
             PyRunner(command="open('ready', 'w').close()", iterPeriod=100, nDo=2)]  # once
O.dt = 2**-13
open("temporary", "w").write(os.path.dirname(O.tmpFilename()))
"""
ADVANCE = SCENE + """
going = rcr.advance(10**9)
assert O.bodies[0].state.pos[0] == O.iter * O.dt, "not a whole step"
open("result", "w").write(f"{going}")
"""
PLAIN = SCENE + "O.run(10**9, True)\n"
MAIN = SCENE + """
from rcr import script
script.run(lambda: O.run(10**9, True))
"""
EARLY = """
import time
open("ready", "w").close()
time.sleep(100)
import rcr
"""
TEST = "--eta 0.5 --particles 60 --seed 2 --strain 0.3 --networks 40".split()
CAMPAIGN = "--jobs 1 --particles 60 --etas 0.5 --seeds 2 --strain 0.3 --networks 40".split()


def wait_until(condition, process=None):
    """Return once the condition holds; fail if the process ends before, or after PATIENCE."""
    end = time.monotonic() + PATIENCE
    while not condition():
        ended = process and process.poll() is not None and not condition()
        assert not ended, f"{process.args} has ended with {process.returncode}"
        assert time.monotonic() < end, "nothing happened"
        time.sleep(0.01)


def start(command, **settings):
    """Start a command that does not ignore SIGHUP, even if nohup runs this process."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    try:
        return subprocess.Popen(command, **settings)
    finally:
        signal.signal(signal.SIGHUP, before)


def started(folder, command, ready, **settings):
    """Start a command in a folder; return its process once the file `ready` exists there."""
    settings = dict(stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                    text=True) | settings
    process = start(list(map(str, command)), cwd=folder, **settings)
    wait_until((folder / ready).exists, process)
    return process


def ended(process):
    """Return the exit code and stderr of a process, as a shell has the code."""
    errors = process.communicate(timeout=PATIENCE)[1]
    code = process.returncode
    return 128 - code if code < 0 else code, errors


def begin_scene(folder, text, before=(), **settings):
    """Start a scene; return the process that waits for its end, and YADE's temporary folder."""
    (folder / "scene.py").write_text(text)
    process = started(folder, [*before, *YADE, "scene.py"], "ready", **settings)
    temporary = pathlib.Path((folder / "temporary").read_text())
    assert temporary.is_dir()
    return process, temporary


def advance_stops(folder, number):
    """`rcr.advance` returns False after a whole step, and the script writes its result."""
    process, temporary = begin_scene(folder, ADVANCE)
    process.send_signal(number)
    assert ended(process)[0] == 0
    assert (folder / "result").read_text() == "False" and not temporary.exists()


def plain_run_ends(folder, number):
    """A run without `rcr.advance` ends with a line or a traceback, and as by the signal."""
    process, temporary = begin_scene(folder, PLAIN)
    process.send_signal(number)
    code, errors = ended(process)
    if number == signal.SIGINT:  # YADE prints a traceback, then comes the summary of the steps
        assert code == 1 and errors.splitlines()[-2] == "KeyboardInterrupt", errors
    else:
        assert code == 128 + number, code
        assert errors.splitlines()[-1] == f"yade-rcr: ended by {signal.Signals(number).name}"
    assert not temporary.exists()


def run_of_main_ends(folder, number):
    """A run within `rcr.script.run` ends with one line, and as by the signal."""
    process, temporary = begin_scene(folder, MAIN)
    process.send_signal(number)
    code, errors = ended(process)
    assert code == 128 + number, code
    assert errors.splitlines()[-1] == "scene.py: stopped" and "Traceback" not in errors, errors
    assert not temporary.exists()


def hangup_ends_the_start(folder):
    """A library of YADE must not take SIGHUP before the script imports rcr."""
    (folder / "scene.py").write_text(EARLY)
    process = started(folder, [*YADE, "scene.py"], "ready")
    process.send_signal(signal.SIGHUP)
    assert ended(process)[0] == 128 + signal.SIGHUP


def timeout_stops_once(folder):
    """`timeout` passes a signal on to the process and to its group: they count as one."""
    process, temporary = begin_scene(folder, ADVANCE, ["timeout", f"{PATIENCE}"])
    process.send_signal(signal.SIGTERM)  # as at the end of its time
    assert ended(process)[0] == 0
    assert (folder / "result").read_text() == "False" and not temporary.exists()


def background_shell_stops(folder, number):
    """A shell without job control starts the script with SIGINT ignored."""
    (folder / "scene.py").write_text(ADVANCE)
    words = shlex.join([*YADE, "scene.py"])
    shell = start(["sh", "-c", f"{words} & echo $! >pid; wait $!; echo $? >code"], cwd=folder,
                  start_new_session=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                  stderr=subprocess.DEVNULL)
    wait_until((folder / "ready").exists, shell)
    os.kill(int((folder / "pid").read_text()), number)
    shell.wait(PATIENCE)
    assert (folder / "result").read_text() == "False" and (folder / "code").read_text() == "0\n"


def nohup_goes_on(folder):
    """SIGHUP that is ignored remains so; SIGTERM stops."""
    process, _ = begin_scene(folder, ADVANCE, ["nohup"])
    process.send_signal(signal.SIGHUP)
    time.sleep(1)
    assert process.poll() is None and not (folder / "result").exists()
    process.send_signal(signal.SIGTERM)
    assert ended(process)[0] == 0 and (folder / "result").read_text() == "False"


def terminal_stops(folder, character):
    """Ctrl-C on a terminal, or its end (None), stops the script once."""
    (folder / "scene.py").write_text(ADVANCE)
    ours, theirs = os.openpty()
    os.set_blocking(ours, False)
    process = start(["setsid", "--ctty", *YADE, "scene.py"], cwd=folder, stdin=theirs,
                    stdout=theirs, stderr=theirs)
    os.close(theirs)

    def read_until(condition):
        def checked():
            with contextlib.suppress(OSError):
                os.read(ours, 10000)
            return condition()

        wait_until(checked)

    read_until((folder / "ready").exists)
    if character:
        os.write(ours, character)
        read_until(lambda: process.poll() is not None)
        assert process.returncode == 0
        os.close(ours)
    else:
        os.close(ours)
        process.wait(PATIENCE)  # it cannot print, so its exit code is open
    assert (folder / "result").read_text() == "False"


def biaxial_resumes(folder, contents):
    """biaxial.py writes a checkpoint and says so; resumed after each signal, it has the same bits.

    `contents(folder)` are the comparable results of a run.
    """
    command = [*YADE, SCRIPTS / "biaxial.py", *TEST, "--out"]
    subprocess.run([*map(str, command), "straight"], cwd=folder, check=True, capture_output=True)
    shutil.rmtree(folder / "out", ignore_errors=True)
    for index, number in enumerate(SIGNALS):
        resume = ["--resume"] if index else []
        ready = "out/network-*.h5" if index else "out/run.json"
        process = started(folder, [*command, "out", *resume], "out/run.json")
        before = set(folder.glob(ready))
        wait_until(lambda: index == 0 or set(folder.glob(ready)) > before, process)
        process.send_signal(number)
        code, errors = ended(process)
        assert code == 128 + number, f"{code}: {errors}"
        assert errors.splitlines()[-1].startswith("biaxial.py: stopped at "), errors
        assert "Traceback" not in errors, errors
        assert (folder / "out" / "checkpoint.yade.gz").exists()
    subprocess.run([*map(str, command), "out", "--resume"], cwd=folder, check=True,
                   capture_output=True)
    assert contents(folder / "out") == contents(folder / "straight")
    for number in SIGNALS:
        network_stops(folder, "straight", number)


def network_stops(folder, run, number):
    """network.py ends in one line and leaves no report."""
    command = [sys.executable, SCRIPTS / "network.py", run, "--out", f"of-{number}"]
    process = started(folder, command, f"of-{number}/.lock")
    process.send_signal(number)
    code, errors = ended(process)
    assert code == 128 + number and errors.splitlines()[-1] == "network.py: stopped", errors
    assert not (folder / f"of-{number}" / "report.html").exists()


def campaign_resumes(folder, contents):
    """scripts/campaign stops its tests with a checkpoint; resumed, it has the same bits."""
    command = [SCRIPTS / "campaign", *CAMPAIGN, "--out"]
    straight = [*YADE, SCRIPTS / "biaxial.py", *TEST, "--threads", "1", "--out", "straight"]
    subprocess.run(list(map(str, straight)), cwd=folder, check=True, capture_output=True)
    run = "runs/particles-60-strain-0.3-networks-40-eta-0.5-seed-2"
    for index, number in enumerate(SIGNALS):
        checkpoint = folder / "out" / run / "checkpoint.yade.gz"
        then = checkpoint.stat().st_mtime_ns if index else 0
        process = started(folder, [*command, "out"], f"out/{run}/run.json")
        saved = lambda: checkpoint.exists() and checkpoint.stat().st_mtime_ns > then
        wait_until(saved, process)
        process.send_signal(number)
        code, errors = ended(process)
        assert code == 128 + number, f"{code}: {errors}"
        expected = "campaign.py: stopped; continue with the same command"
        assert errors.splitlines()[-1] == expected, errors
        log = (folder / "out" / run / "log").read_text()
        assert "biaxial.py: stopped at " in log, log
    subprocess.run([*map(str, command), "out"], cwd=folder, check=True, capture_output=True)
    assert contents(folder / "out" / run) == contents(folder / "straight")


def bytes_of(folder):
    """The history and the names of all files of a run."""
    names = sorted(path.name for path in folder.glob("*.h5"))
    return (folder / "history.csv").read_bytes(), names


def scene_cases():
    """(name, function of a folder) of the cases that run a scene."""
    for number in SIGNALS:
        name = number.name
        yield f"advance-{name}", lambda folder, n=number: advance_stops(folder, n)
        yield f"plain-{name}", lambda folder, n=number: plain_run_ends(folder, n)
        yield f"main-{name}", lambda folder, n=number: run_of_main_ends(folder, n)
        yield f"background-{name}", lambda folder, n=number: background_shell_stops(folder, n)
    yield "early SIGHUP", hangup_ends_the_start
    yield "timeout", timeout_stops_once
    yield "nohup", nohup_goes_on
    yield "Ctrl-C", lambda folder: terminal_stops(folder, b"\x03")
    yield "closed terminal", lambda folder: terminal_stops(folder, None)


def main():
    folder = pathlib.Path(sys.argv[1]).resolve()
    cases = dict(scene_cases())
    if sys.argv[2:]:
        YADE[0] = sys.argv[2]
        del cases["early SIGHUP"]  # only the environment of the scripts keeps it from UCX
    else:
        cases.update(biaxial=lambda at: biaxial_resumes(at, bytes_of),
                     campaign=lambda at: campaign_resumes(at, bytes_of))
    failed = []
    for name, case in cases.items():
        at = folder / name.replace(" ", "-")
        shutil.rmtree(at, ignore_errors=True)
        at.mkdir(parents=True)
        try:
            case(at)
        except Exception as error:
            failed.append(name)
            print(f"{name}: {error!r}", flush=True)
        else:
            print(f"{name}: right", flush=True)
    print(f"{len(cases)} cases, wrong: {', '.join(failed) or 'none'}")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()

"""What the default tests leave out: each check is a function that returns its verdict and a line about it; a table ends the run.

Builds stand in build/check/NAME, logs beside them in build/check/NAME.log.
"""

import argparse
import importlib
import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build" / "check"
TESTS = "tests/kernel"
PYTEST = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", f"--confcutdir={TESTS}"]  # without what loads YADE

# The sanitizers have address spaces, threads and processes of their own, so these tests cannot do what they want to.
LEFT_OUT = {
    "asan": ["cannot_hire"],
    "ubsan": [],
    "tsan": ["cannot_hire", "forked", "million", "dropped_teams"],
}
SANITIZERS = {
    "asan": dict(flags="-fsanitize=address -D_GLIBCXX_ASSERTIONS", preload="libasan.so", variable="ASAN_OPTIONS", options="detect_leaks=0"),
    "ubsan": dict(flags="-fsanitize=undefined", preload=None, variable="UBSAN_OPTIONS", options="print_stacktrace=1"),
    "tsan": dict(flags="-fsanitize=thread", preload="libtsan.so", variable="TSAN_OPTIONS", options="halt_on_error=1"),
}


def run(command, log, **settings):
    """Exit code of a command whose output goes to the end of the log."""
    with open(log, "a") as output:
        print("$", *command, file=output, flush=True)
        return subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, **settings).returncode


def build_kernel(name, flags, source=ROOT):
    """Builds the kernels alone with these flags; returns the folder that holds the package `rcr`, or None."""
    folder, package = FOLDER / name, FOLDER / name / "package" / "rcr"
    package.mkdir(parents=True, exist_ok=True)
    for entry in (ROOT / "py" / "rcr").iterdir():
        if entry.suffix != ".so" and not (package / entry.name).exists():
            (package / entry.name).symlink_to(entry)
    configure = ["cmake", "-S", source, "-B", folder / "build", "-G", "Ninja", "-DRCR_PLUGIN=OFF", f"-DRCR_PACKAGE={package}",
                 "-DCMAKE_BUILD_TYPE=Check", f"-DCMAKE_CXX_FLAGS={flags}"]  # fmt: skip
    log = FOLDER / f"{name}.log"
    if run([*map(str, configure)], log) or run(["cmake", "--build", str(folder / "build"), "--target", "_kernel"], log):
        return None
    return package.parent


def environment(package, **changes):
    """Python of this environment with that package, and without YADE: the kernels' tests need none."""
    return dict(os.environ, PYTHONPATH=os.pathsep.join([str(package), str(ROOT / "tests")]), **changes)


def last_line(log):
    lines = [line for line in log.read_text(errors="replace").splitlines() if line.strip()]
    return lines[-1].strip("= ") if lines else ""


def sanitize(name, arguments):
    """Builds the kernels with a sanitizer and runs their tests under it."""
    sanitizer, log = SANITIZERS[name], FOLDER / f"{name}.log"
    package = build_kernel(name, f"-O1 -g -fno-omit-frame-pointer {sanitizer['flags']}")
    if package is None:
        return False, f"does not build, see {log.relative_to(ROOT)}"
    reports = FOLDER / name / "report"  # what goes to stderr, pytest keeps to itself
    for report in reports.parent.glob("report.*"):
        report.unlink()
    changes = {sanitizer["variable"]: f"{sanitizer['options']}:log_path={reports}", "OMP_NUM_THREADS": "1"}
    if sanitizer["preload"]:
        changes["LD_PRELOAD"] = subprocess.check_output(["g++", f"-print-file-name={sanitizer['preload']}"], text=True).strip()
    command = [*PYTEST, TESTS, *arguments]
    if LEFT_OUT[name]:
        command += ["-k", " and ".join(f"not {test}" for test in LEFT_OUT[name])]
    # addresses at random may lie where the sanitizers' shadows do
    code = run(["setarch", "-R", *command], log, cwd=ROOT, env=environment(package, **changes))
    found = sorted(reports.parent.glob("report.*"))
    if found:
        line = next((line for line in found[0].read_text(errors="replace").splitlines() if "rror" in line or "WARNING" in line), "")
        return False, f"{len(found)} reports, first {found[0].relative_to(ROOT)}: {line.strip()}"
    return code == 0, last_line(log) if code == 0 else f"exit code {code}, {last_line(log)}; see {log.relative_to(ROOT)}"


def script(name, *command):
    """Runs a script that ends with a line on what it found, and with an exit code other than 0 where that is wrong."""
    log = FOLDER / f"{name}.log"
    code = run([str(part) for part in command], log, cwd=ROOT)
    return code == 0, last_line(log) + ("" if code == 0 else f"; see {log.relative_to(ROOT)}")


CHECKS = {
    "asan": (lambda arguments: sanitize("asan", arguments), "the kernels' tests under AddressSanitizer, with bounds checks"),
    "ubsan": (lambda arguments: sanitize("ubsan", arguments), "the kernels' tests under UndefinedBehaviorSanitizer"),
    "tsan": (lambda arguments: sanitize("tsan", arguments), "the kernels' tests under ThreadSanitizer"),
    "mutants": (lambda arguments: importlib.import_module("mutants").run(arguments), "the kernels' tests against kernels with one mistake each"),
    "scenes": (lambda arguments: script("scenes", sys.executable, "tests/endurance/scene_fuzzer.py", *(arguments or ["--scenes", "2000"])),
               "scenes drawn at random: each runs within its bounds or is refused before anything moves"),
    "driven": (lambda arguments: script("driven", "scripts/yade-rcr", "-n", "-x", "scripts/driven_scenes.py", *(arguments or ["--count", "200", "--out", str(FOLDER / "driven.csv")])),
               "driven scenes drawn at random, rigid beside springs"),
    "kills": (lambda arguments: script("kills", sys.executable, "tests/endurance/kills.py", *(arguments or ["writes", "1000", "runs", "50", "campaigns", "5"])),
              "writes, runs and campaigns killed at random moments"),
}  # fmt: skip


def main():
    parser = argparse.ArgumentParser(
        prog="check", description="Run what the default tests leave out.", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="\n".join(f"{name:10} {about}" for name, (_, about) in CHECKS.items()),
    )  # fmt: skip
    parser.add_argument("what", nargs="*", help=f"some of {' '.join(CHECKS)}; all if none is given")
    arguments = sys.argv[1:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_args(arguments[:split])
    for name in options.what:
        if name not in CHECKS:
            parser.error(f"'{name}' is not known: give some of {' '.join(CHECKS)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in options.what or CHECKS:
        print(f"check: {name}: {CHECKS[name][1]} …", file=sys.stderr, flush=True)
        (FOLDER / f"{name}.log").unlink(missing_ok=True)
        start = time.monotonic()
        right, about = CHECKS[name][0](arguments[split + 1 :])
        rows.append((name, "clean" if right else "FAILS", f"{time.monotonic() - start:.0f} s", about))
    width = [max(len(row[k]) for row in rows) for k in range(3)]
    for row in rows:
        print("  ".join([*(cell.ljust(w) for cell, w in zip(row, width)), row[3]]))
    sys.exit(any(row[1] != "clean" for row in rows))


if __name__ == "__main__":
    sys.modules["check"] = sys.modules["__main__"]  # for the checks in files of their own
    main()

"""Runs checks beyond the default tests, and prints a table.

A check is a function of its name and arguments. It returns a verdict (True, False, or None if it
cannot run) and a line about it. Builds are in build/check/NAME, logs in build/check/NAME.log.
`--record` adds the rows to docs/measurements/checks.csv.
"""

import argparse
import csv
import datetime
import importlib
import os
import re
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build" / "check"
TESTS = "tests/kernel"
PYTEST = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
WITHOUT_YADE = [f"--confcutdir={TESTS}"]
SOAK, FUZZER = "tests/endurance/soak.py", "tests/endurance/scene_fuzzer.py"
RECORD = ROOT / "docs" / "measurements" / "checks.csv"

# Tests that need address spaces, threads or processes without a sanitizer.
LEFT_OUT = {"asan": ["fewer_threads"], "ubsan": [], "tsan": ["forked", "million"]}
SANITIZERS = {
    "asan": dict(flags="-fsanitize=address -D_GLIBCXX_ASSERTIONS",
                 preload=["libasan.so", "libstdc++.so"], ASAN_OPTIONS="detect_leaks=0"),
    "ubsan": dict(flags="-fsanitize=undefined", preload=[], UBSAN_OPTIONS="print_stacktrace=1"),
    "tsan": dict(flags="-fsanitize=thread", preload=["libtsan.so"], TSAN_OPTIONS="halt_on_error=1"),
    # The plugin and rcr._kernel both contain the kernels, which looks like a violation of the ODR.
    # YADE's libraries lack type information for `vptr`.
    "plugin-asan": dict(
        flags="-fsanitize=address,undefined -fno-sanitize=vptr -D_GLIBCXX_ASSERTIONS",
        preload=["libasan.so", "libubsan.so", "libstdc++.so"],
        ASAN_OPTIONS="detect_leaks=0:detect_odr_violation=0", UBSAN_OPTIONS="print_stacktrace=1"),
    # YADE, Boost and OpenMP are compiled without it, so their locks and barriers are unknown.
    "plugin-tsan": dict(flags="-fsanitize=thread", preload=["libtsan.so"],
                        TSAN_OPTIONS="ignore_noninstrumented_modules=1:report_thread_leaks=0"),
}


def run(command, log, **settings):
    """Run a command, append its output to the log; returns its exit code."""
    with open(log, "a") as output:
        print("$", *command, file=output, flush=True)
        settings.update(stdout=output, stderr=subprocess.STDOUT)
        return subprocess.run(command, **settings).returncode


def build(name, flags, source=ROOT, plugin=False):
    """Build kernels, and the `plugin`, with these flags; return the package's folder or None."""
    folder, package = FOLDER / name, FOLDER / name / "package" / "rcr"
    package.mkdir(parents=True, exist_ok=True)
    for entry in (ROOT / "py" / "rcr").iterdir():
        if entry.suffix != ".so" and not (package / entry.name).exists():
            (package / entry.name).symlink_to(entry)
    with_plugin = [f"-DYADE_SOURCE_DIR={yade_source()}"] if plugin else ["-DRCR_PLUGIN=OFF"]
    configure = ["cmake", "-S", source, "-B", folder / "build", "-G", "Ninja", *with_plugin,
                 f"-DRCR_PACKAGE={package}", "-DCMAKE_BUILD_TYPE=Check",
                 f"-DCMAKE_CXX_FLAGS={flags}"]
    if run([*map(str, configure)], FOLDER / f"{name}.log") or not compiled(name, plugin):
        return None
    return package.parent


def compiled(name, plugin=False):
    """Compile changed files; returns True on success.

    A file with YADE's headers takes 4 GB under the sanitizers, so the plugin compiles one at a
    time.
    """
    options = ["--parallel", "1"] if plugin else ["--target", "_kernel"]
    command = ["cmake", "--build", str(FOLDER / name / "build"), *options]
    return run(command, FOLDER / f"{name}.log") == 0


def yade_source():
    """Folder of YADE's headers, from the ordinary build."""
    lines = (ROOT / "build" / "CMakeCache.txt").read_text().splitlines()
    return next(line.split("=", 1)[1] for line in lines if line.startswith("YADE_SOURCE_DIR"))


def environment(package, yade=False, **changes):
    """Environment variables for Python with that package, and with YADE if `yade`."""
    path = [str(package), str(ROOT / "tests"), *([os.environ["PYTHONPATH"]] if yade else [])]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(path), **changes)


def last_line(log):
    lines = [line for line in log.read_text(errors="replace").splitlines() if line.strip()]
    return lines[-1].strip("= ") if lines else ""


def sanitize(name, commands, plugin=False):
    """Run commands under a sanitizer; the line has their last lines, or the first report."""
    sanitizer, log = dict(SANITIZERS[name]), FOLDER / f"{name}.log"
    flags = f"-O1 -g1 -fno-omit-frame-pointer {sanitizer.pop('flags')}"
    package = build(name, flags, plugin=plugin)
    if package is None:
        return False, f"does not build, see {log.relative_to(ROOT)}"
    reports = FOLDER / name / "report"  # pytest hides stderr
    for report in reports.parent.glob("report.*"):
        report.unlink()
    queries = [["g++", f"-print-file-name={library}"] for library in sanitizer.pop("preload")]
    preload = [subprocess.check_output(query, text=True).strip() for query in queries]
    changes = {variable: f"{value}:log_path={reports}" for variable, value in sanitizer.items()}
    changes.update({"LD_PRELOAD": " ".join(preload)} if preload else {}, OMP_NUM_THREADS="1")
    variables, last = environment(package, plugin, **changes), []
    for command in commands:
        # random addresses may collide with the shadow memory of a sanitizer
        code = run(["setarch", "-R", *command], log, cwd=ROOT, env=variables)
        last.append(last_line(log))
        found = sorted(reports.parent.glob("report.*"))
        if found:
            lines = found[0].read_text(errors="replace").splitlines()
            line = next((line for line in lines if "rror" in line or "WARNING" in line), "").strip()
            return False, f"{len(found)} reports, first {found[0].relative_to(ROOT)}: {line}"
        if code:
            return False, f"exit code {code}, {last[-1]}; see {log.relative_to(ROOT)}"
    return True, "; ".join(last)


def sanitize_kernels(name, arguments):
    chosen = " and ".join(f"not {test}" for test in LEFT_OUT[name])
    left_out = ["-k", chosen] if chosen else []
    return sanitize(name, [[*PYTEST, *WITHOUT_YADE, TESTS, *arguments, *left_out]])


def sanitize_plugin(name, arguments):
    """Soak, scene fuzzer and the smallest case of a pair that grows within a step.

    The sanitizer delays the release of memory, so its growth is not bounded.
    """
    return sanitize(name, [
        [*PYTEST, "-p", "no:warnings", "tests/yade/law/test_curved_paths.py", "-k", "gains_a"],
        [sys.executable, FUZZER, "--scenes", "300"],
        [sys.executable, SOAK, "--growth", "inf", *(arguments or ["--minutes", "5"])],
    ], plugin=True)


def sanitize_session(name, arguments):
    """A session whose threads read and set the engine while it runs."""
    tests = "tests/yade/run/test_arrays.py", "-k", "during_a_run or pause"
    return sanitize(name, [[*PYTEST, "-p", "no:warnings", *tests, *arguments]], plugin=True)


def script(name, *command):
    """Run a script; its exit code is the verdict, its last line the line of the check."""
    log = FOLDER / f"{name}.log"
    code = run(command, log, cwd=ROOT)
    return code == 0, last_line(log) + ("" if code == 0 else f"; see {log.relative_to(ROOT)}")


def damage(name, arguments):
    """Tests of the readers with twenty times as many damaged files, with their counts."""
    command = ["env", "RCR_DAMAGE=20", *PYTEST, "tests/python/files/test_damaged_files.py"]
    right, about = script(name, *command, *arguments)
    counts = re.findall(r"^damaged files: .*$", (FOLDER / f"{name}.log").read_text(), re.M)
    return right, "; ".join([*counts, about])


def properties(name, arguments):
    """Property tests, each with a thousand new examples."""
    options = ["-m", "hypothesis", "--hypothesis-profile=long", "--hypothesis-show-statistics"]
    right, about = script(name, *PYTEST, *options, *arguments)
    counts = re.findall(r"(\d+) passing examples", (FOLDER / f"{name}.log").read_text())
    return right, f"{sum(map(int, counts))} examples; {about}"


def python(file, *defaults):
    """A check that runs a Python file."""
    return lambda name, arguments: script(name, sys.executable, file, *(arguments or defaults))


def truth(name, arguments):
    """Exact solutions against the kernels alone, and against scenes in YADE."""
    runs = [[*arguments]] if arguments else [["--scenes", "3000"], ["--scenes", "500", "--yade"]]
    found = [script(name, sys.executable, "tests/endurance/truth.py", *run) for run in runs]
    return all(right for right, _ in found), "; ".join(about for _, about in found)


def before(name, arguments):
    """Result of a check that scripts/check has run; exit code 77: it cannot run here."""
    log = FOLDER / f"check-{name}.log"
    right = {"0": True, "77": None}.get(os.environ[f"YADE_RCR_CHECK_{name.upper()}"], False)
    return right, last_line(log) + (f"; see {log.relative_to(ROOT)}" if right is False else "")


def driven(name, arguments):
    """Random driven scenes."""
    options = arguments or ["--count", "200", "--out", str(FOLDER / "driven.csv")]
    return script(name, "scripts/yade-rcr", "-n", "-x", "benchmarks/driven_scenes.py", *options)


CHECKS = {
    "slow": (lambda name, arguments: script(name, *PYTEST, "-m", "slow", *arguments), "slow tests"),
    "asan": (sanitize_kernels, "kernel tests under AddressSanitizer, with bounds checks"),
    "ubsan": (sanitize_kernels, "kernel tests under UndefinedBehaviorSanitizer"),
    "tsan": (sanitize_kernels, "kernel tests under ThreadSanitizer"),
    "plugin-asan": (sanitize_plugin, "soak and scenes in YADE under AddressSanitizer and "
                    "UndefinedBehaviorSanitizer, with bounds checks"),
    "plugin-tsan": (sanitize_session, "a session in YADE under ThreadSanitizer"),
    "mutants": (lambda name, arguments: importlib.import_module("mutants").run(arguments),
                "kernel tests against kernels with one error each"),
    "scenes": (python(FUZZER, "--scenes", "2000"),
               "random scenes: each keeps its bounds or is rejected before the first step"),
    "runs": (python("tests/endurance/run_fuzzer.py", "--scenes", "1000"),
             "random runs with changes by PyRunners: arrays give the bits of engines"),
    "symmetries": (python("tests/endurance/symmetries.py", "--scenes", "3000"),
                   "random small scenes: steps commute with mirrors, turns, shifts, orders and "
                   "units"),
    "truth": (truth, "random small scenes: what has converged is right to 1 %, by exact solutions"),
    "sessions": (python("tests/endurance/sessions.py", "--scenes", "300"),
                 "random calls that start, pause, save and replace runs in the background"),
    "soak": (python(SOAK), "random scenes with repeated changes; memory stays constant"),
    "driven": (driven, "random driven scenes, rigid contacts against springs"),
    "large": (python("tests/endurance/large.py"), "2^20 separate grains, 10^5 grains in a pile"),
    "kills": (python("tests/endurance/kills.py", *"writes 1000 runs 50 campaigns 5".split()),
              "writes, runs and campaigns killed at random moments"),
    "signals": (before, "SIGINT, SIGTERM, SIGHUP to the scripts, from outside of the environment"),
    "damage": (damage, "twenty times as many damaged files: each is read or rejected in one line"),
    "properties": (properties, "property tests, a thousand new inputs each"),
    "tidy": (before, "clang-tidy on the kernels"),
    "coverage": (before, "line coverage of the kernels by their tests"),
    "docs": (python("docs/build.py"), "site of the pages, without warnings"),
    "slurm": (before, "campaign on SLURM with a cancelled job; results equal those of a local "
              "campaign"),
    "deb": (before, "Debian package: installed in a clean Debian, used by plain yade, removed "
            "completely"),
}
VERDICTS = {True: "clean", False: "FAILS", None: "left out"}


def options():
    """Names of the checks, `--record`, and the arguments that are passed to the checks."""
    about = [f"{name:12} {about}" for name, (_, about) in CHECKS.items()]
    about += ["", "Arguments after -- are passed to the check: check soak -- --minutes 60"]
    parser = argparse.ArgumentParser(
        prog="check", description="Run checks beyond the default tests.",
        formatter_class=argparse.RawDescriptionHelpFormatter, epilog="\n".join(about))
    parser.add_argument("names", nargs="*", metavar="CHECK",
                        help=f"some of {' '.join(CHECKS)} (default: all)")
    parser.add_argument("--record", action="store_true",
                        help=f"add the rows to {RECORD.relative_to(ROOT)}")
    arguments = sys.argv[1:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    given = parser.parse_args(arguments[:split])
    for name in given.names:
        if name not in CHECKS:
            parser.error(f"unknown check '{name}': give some of {' '.join(CHECKS)}")
    return given.names or list(CHECKS), given.record, arguments[split + 1:]


def main():
    names, is_recorded, passed = options()
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in names:
        print(f"check: {name}: {CHECKS[name][1]} …", file=sys.stderr, flush=True)
        (FOLDER / f"{name}.log").unlink(missing_ok=True)
        start = time.monotonic()
        right, about = CHECKS[name][0](name, passed)
        seconds = f"{time.monotonic() - start:.0f}"
        now, commit = datetime.date.today().isoformat(), os.environ.get("YADE_RCR_COMMIT", "")
        rows.append([name, VERDICTS[right], f"{seconds} s", about])
        if is_recorded:  # columns: see the first line of the file
            with open(RECORD, "a", newline="") as file:
                row = now, commit, name, " ".join(passed), VERDICTS[right], seconds, about
                csv.writer(file, lineterminator="\n").writerow(row)
    width = [max(map(len, column)) for column in zip(*rows)]
    for row in rows:
        print("  ".join(cell.ljust(w) for cell, w in zip(row, width)).rstrip())
    sys.exit(any(row[1] == VERDICTS[False] for row in rows))


if __name__ == "__main__":
    sys.modules["check"] = sys.modules["__main__"]  # mutants.py imports it
    main()

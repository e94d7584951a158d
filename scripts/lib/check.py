"""What the default tests leave out: each check is a function that returns its verdict and a line about it; a table ends the run.

Builds stand in build/check/NAME, logs beside them in build/check/NAME.log. With `--record` the rows go to docs/measurements/checks.csv, of which
docs/measurements/checks.md is made.
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
SOAK, FUZZER, RUNS, LARGE = (
    f"tests/endurance/{name}.py" for name in ("soak", "scene_fuzzer", "run_fuzzer", "large")
)
RECORD, PAGE = (ROOT / "docs" / "measurements" / f"checks.{suffix}" for suffix in ("csv", "md"))
COLUMNS = ["date", "commit", "check", "options", "verdict", "seconds", "what"]

# The sanitizers have address spaces, threads and processes of their own, so these tests cannot do what they want to.
LEFT_OUT = {
    "asan": ["cannot_hire"],
    "ubsan": [],
    "tsan": ["cannot_hire", "forked", "million", "dropped_teams"],
}
SANITIZERS = {
    "asan": dict(flags="-fsanitize=address -D_GLIBCXX_ASSERTIONS", preload=["libasan.so", "libstdc++.so"], ASAN_OPTIONS="detect_leaks=0"),
    "ubsan": dict(flags="-fsanitize=undefined", preload=[], UBSAN_OPTIONS="print_stacktrace=1"),
    "tsan": dict(flags="-fsanitize=thread", preload=["libtsan.so"], TSAN_OPTIONS="halt_on_error=1"),
    # The plugin and rcr._kernel hold the same kernels, each its own, which looks like two definitions of one. YADE's libraries lack what `vptr` asks for.
    "plugin-asan": dict(flags="-fsanitize=address,undefined -fno-sanitize=vptr -D_GLIBCXX_ASSERTIONS", preload=["libasan.so", "libubsan.so", "libstdc++.so"],
                        ASAN_OPTIONS="detect_leaks=0:detect_odr_violation=0", UBSAN_OPTIONS="print_stacktrace=1"),
}  # fmt: skip


def run(command, log, **settings):
    """Exit code of a command whose output goes to the end of the log."""
    with open(log, "a") as output:
        print("$", *command, file=output, flush=True)
        return subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, **settings).returncode


def build(name, flags, source=ROOT, plugin=False):
    """Builds the kernels, and the plugin if asked for, with these flags; returns the folder that holds the package `rcr`, or None."""
    folder, package = FOLDER / name, FOLDER / name / "package" / "rcr"
    package.mkdir(parents=True, exist_ok=True)
    for entry in (ROOT / "py" / "rcr").iterdir():
        if entry.suffix != ".so" and not (package / entry.name).exists():
            (package / entry.name).symlink_to(entry)
    with_plugin = [f"-DYADE_SOURCE_DIR={yade_source()}"] if plugin else ["-DRCR_PLUGIN=OFF"]
    configure = ["cmake", "-S", source, "-B", folder / "build", "-G", "Ninja", *with_plugin, f"-DRCR_PACKAGE={package}",
                 "-DCMAKE_BUILD_TYPE=Check", f"-DCMAKE_CXX_FLAGS={flags}"]  # fmt: skip
    if run([*map(str, configure)], FOLDER / f"{name}.log") or not compiled(name, plugin):
        return None
    return package.parent


def compiled(name, plugin=False):
    """Whether what changed since it was built compiles; a file with YADE's headers takes 4 GB under the sanitizers, so these go one at a time."""
    wanted = ["--parallel", "1"] if plugin else ["--target", "_kernel"]
    return run(["cmake", "--build", str(FOLDER / name / "build"), *wanted], FOLDER / f"{name}.log") == 0


def yade_source():
    """The folder of YADE's headers, as the ordinary build has it."""
    lines = (ROOT / "build" / "CMakeCache.txt").read_text().splitlines()
    return next(line.split("=", 1)[1] for line in lines if line.startswith("YADE_SOURCE_DIR"))


def environment(package, yade=False, **changes):
    """Python of this environment with that package; without YADE, which the kernels' tests do not need, unless it is asked for."""
    path = [str(package), str(ROOT / "tests"), *([os.environ["PYTHONPATH"]] if yade else [])]
    return dict(os.environ, PYTHONPATH=os.pathsep.join(path), **changes)


def last_line(log):
    lines = [line for line in log.read_text(errors="replace").splitlines() if line.strip()]
    return lines[-1].strip("= ") if lines else ""


def sanitize(name, commands, plugin=False):
    """Builds with a sanitizer and runs commands under it; the line is that of the last command, or the first report."""
    sanitizer, log = dict(SANITIZERS[name]), FOLDER / f"{name}.log"
    package = build(name, f"-O1 -g1 -fno-omit-frame-pointer {sanitizer.pop('flags')}", plugin=plugin)
    if package is None:
        return False, f"does not build, see {log.relative_to(ROOT)}"
    reports = FOLDER / name / "report"  # what goes to stderr, pytest keeps to itself
    for report in reports.parent.glob("report.*"):
        report.unlink()
    preload = [subprocess.check_output(["g++", f"-print-file-name={library}"], text=True).strip() for library in sanitizer.pop("preload")]
    changes = {variable: f"{value}:log_path={reports}" for variable, value in sanitizer.items()}
    changes.update({"LD_PRELOAD": " ".join(preload)} if preload else {}, OMP_NUM_THREADS="1")
    told = []
    for command in commands:
        # addresses at random may lie where the sanitizers' shadows do
        code = run(["setarch", "-R", *command], log, cwd=ROOT, env=environment(package, plugin, **changes))
        told.append(last_line(log))
        found = sorted(reports.parent.glob("report.*"))
        if found:
            line = next((line for line in found[0].read_text(errors="replace").splitlines() if "rror" in line or "WARNING" in line), "")
            return False, f"{len(found)} reports, first {found[0].relative_to(ROOT)}: {line.strip()}"
        if code:
            return False, f"exit code {code}, {told[-1]}; see {log.relative_to(ROOT)}"
    return True, "; ".join(told)


def sanitize_kernels(name, arguments):
    left_out = ["-k", " and ".join(f"not {test}" for test in LEFT_OUT[name])] if LEFT_OUT[name] else []
    return sanitize(name, [[*PYTEST, *WITHOUT_YADE, TESTS, *arguments, *left_out]])


def sanitize_plugin(arguments):
    """The soak, the scene fuzzer and the least case of a pair that grows within a step. Memory grows by what the sanitizer holds back."""
    python = [sys.executable]
    return sanitize("plugin-asan", [
        [*PYTEST, "-p", "no:warnings", "tests/yade/test_f01_stale_points.py"],
        [*python, FUZZER, "--scenes", "300"],
        [*python, SOAK, "--growth", "inf", *(arguments or ["--minutes", "5"])],
    ], plugin=True)  # fmt: skip


def script(name, *command):
    """Runs a script that ends with a line on what it found, and with an exit code other than 0 where that is wrong."""
    log = FOLDER / f"{name}.log"
    code = run([str(part) for part in command], log, cwd=ROOT)
    return code == 0, last_line(log) + ("" if code == 0 else f"; see {log.relative_to(ROOT)}")


def damage(arguments):
    """The readers' tests with twenty times as many damaged files, and how many of them were read and refused."""
    right, about = script("damage", "env", "RCR_DAMAGE=20", *PYTEST, "tests/python/test_damaged_files.py", *arguments)
    return right, "; ".join([line for line in (FOLDER / "damage.log").read_text().splitlines() if line.startswith("damaged files: ")] + [about])


def properties(arguments):
    """The property tests, each with a thousand new examples."""
    options = ["-m", "hypothesis", "--hypothesis-profile=long", "--hypothesis-show-statistics"]
    right, about = script("properties", *PYTEST, *options, *arguments)
    counts = [int(count) for count in re.findall(r"(\d+) passing examples", (FOLDER / "properties.log").read_text())]
    return right, f"{sum(counts)} examples; {about}"


def python(name, file, *defaults):
    return lambda arguments: script(name, sys.executable, file, *(arguments or defaults))


def before(name):
    """How it went with a check that scripts/check has run before; 77 is the exit code of one that cannot be run here."""
    log = FOLDER / f"check-{name}.log"
    right = {"0": True, "77": None}.get(os.environ[f"YADE_RCR_CHECK_{name.upper()}"], False)
    return right, last_line(log) + (f"; see {log.relative_to(ROOT)}" if right is False else "")


CHECKS = {
    "slow": (lambda arguments: script("slow", *PYTEST, "-m", "slow", *arguments), "slow tests"),
    "asan": (lambda arguments: sanitize_kernels("asan", arguments), "kernel tests under AddressSanitizer, with bounds checks"),
    "ubsan": (lambda arguments: sanitize_kernels("ubsan", arguments), "kernel tests under UndefinedBehaviorSanitizer"),
    "tsan": (lambda arguments: sanitize_kernels("tsan", arguments), "kernel tests under ThreadSanitizer"),
    "plugin-asan": (sanitize_plugin, "soak and scenes in YADE under AddressSanitizer and UndefinedBehaviorSanitizer, with bounds checks"),
    "mutants": (lambda arguments: importlib.import_module("mutants").run(arguments), "kernel tests against kernels with one error each"),
    "scenes": (python("scenes", FUZZER, "--scenes", "2000"), "random scenes: each keeps its bounds or is rejected before the first step"),
    "runs": (python("runs", RUNS, "--scenes", "1000", "--without", "F70"),
             "random runs with changes by PyRunners: arrays give the bits of engines"),
    "soak": (python("soak", SOAK), "random scenes with repeated changes; memory stays constant"),
    "driven": (lambda arguments: script("driven", "scripts/yade-rcr", "-n", "-x", "benchmarks/driven_scenes.py", *(arguments or ["--count", "200", "--out", str(FOLDER / "driven.csv")])),
               "random driven scenes, rigid contacts against springs"),
    "large": (python("large", LARGE), "2^20 separate grains, 10^5 grains in a pile"),
    "kills": (python("kills", "tests/endurance/kills.py", "writes", "1000", "runs", "50", "campaigns", "5"), "writes, runs and campaigns killed at random moments"),
    "damage": (damage, "twenty times as many damaged files: each is read or rejected in one line"),
    "properties": (properties, "property tests, a thousand new inputs each"),
    "tidy": (lambda arguments: before("tidy"), "clang-tidy on the kernels"),
    "coverage": (lambda arguments: before("coverage"), "line coverage of the kernels by their tests"),
    "docs": (python("docs", "docs/build.py"), "site of the pages, without warnings"),
    "slurm": (lambda arguments: before("slurm"), "campaign on SLURM with a cancelled job; results equal those of a local campaign"),
    "deb": (lambda arguments: before("deb"), "Debian package: installed in a clean Debian 13, used by plain yade, removed completely"),
}  # fmt: skip
VERDICTS = {True: "clean", False: "FAILS", None: "left out"}


def record(rows):
    """Adds rows to the table of all runs, and makes the page anew: the last row of each check and its options."""
    RECORD.parent.mkdir(parents=True, exist_ok=True)
    new = not RECORD.exists()
    with open(RECORD, "a", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        if new:
            table.writeheader()
        table.writerows(rows)
    with open(RECORD, newline="") as file:
        last = {(row["check"], row["options"]): row for row in csv.DictReader(file)}
    PAGE.write_text(page([row for name in CHECKS for (check, _), row in last.items() if check == name]))


def page(rows):
    """The table of these rows in Markdown."""
    lines = ["# Checks", "", "Last run of each check of `scripts/check`, by its options.",
             "`checks.csv` holds all runs; `scripts/check --record` writes both files.", "", "| check | what it does | verdict | found | date, commit | s |", "|---|---|---|---|---|---|"]  # fmt: skip
    cell = lambda text: text.replace("|", "\\|")
    for row in rows:
        options = f" `{row['options']}`" if row["options"] else ""
        lines.append(f"| {row['check']}{options} | {CHECKS[row['check']][1]} | {row['verdict']} | {cell(row['what'])} | {row['date']}, {row['commit']} | {row['seconds']} |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(
        prog="check", description="Run what the default tests leave out.", formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="\n".join(f"{name:12} {about}" for name, (_, about) in CHECKS.items()) + "\n\nWhat stands after -- goes to the check: check soak -- --minutes 60",
    )  # fmt: skip
    parser.add_argument("what", nargs="*", help=f"some of {' '.join(CHECKS)}; all if none is given")
    parser.add_argument("--record", action="store_true", help=f"add the rows to {RECORD.relative_to(ROOT)}")
    arguments = sys.argv[1:]
    split = arguments.index("--") if "--" in arguments else len(arguments)
    options = parser.parse_args(arguments[:split])
    passed = arguments[split + 1 :]
    for name in options.what:
        if name not in CHECKS:
            parser.error(f"'{name}' is not known: give some of {' '.join(CHECKS)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    rows = []
    for name in options.what or CHECKS:
        print(f"check: {name}: {CHECKS[name][1]} …", file=sys.stderr, flush=True)
        (FOLDER / f"{name}.log").unlink(missing_ok=True)
        start = time.monotonic()
        right, about = CHECKS[name][0](passed)
        rows.append(dict(date=datetime.date.today().isoformat(), commit=os.environ.get("YADE_RCR_COMMIT", ""), check=name, options=" ".join(passed),
                         verdict=VERDICTS[right], seconds=f"{time.monotonic() - start:.0f}", what=about))  # fmt: skip
        if options.record:
            record(rows[-1:])
    shown = [[row["check"], row["verdict"], f"{row['seconds']} s", row["what"]] for row in rows]
    width = [max(len(row[k]) for row in shown) for k in range(3)]
    for row in shown:
        print("  ".join([*(cell.ljust(w) for cell, w in zip(row, width)), row[3]]))
    sys.exit(any(row["verdict"] == VERDICTS[False] for row in rows))


if __name__ == "__main__":
    sys.modules["check"] = sys.modules["__main__"]  # for the checks in files of their own
    main()

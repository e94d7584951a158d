"""What compilers and their counters tell of the kernels: `analyze.py tidy` runs clang-tidy, `analyze.py coverage` counts the lines that tests reach.

check-analyzers runs it where clang-tidy and gcovr are; the last line is the verdict.
"""

import subprocess
import sys

from check import FOLDER, PYTEST, ROOT, TESTS, WITHOUT_YADE, build, environment, last_line, run


def tidy():
    """clang-tidy on the kernels, with the checks of .clang-tidy."""
    folder, log = FOLDER / "tidy", FOLDER / "tidy.log"
    log.unlink(missing_ok=True)
    if run(["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", "-DRCR_PLUGIN=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", f"-DRCR_PACKAGE={folder}"], log):
        return False, f"does not configure, see {log.relative_to(ROOT)}"
    files = sorted(str(path) for path in (ROOT / "pkg" / "kernel").rglob("*.cpp"))
    code = run(["clang-tidy", "-p", str(folder), "--quiet", "--warnings-as-errors=*", *files], log)
    found = sum(": warning:" in line or ": error:" in line for line in log.read_text(errors="replace").splitlines())
    return code == 0, f"{len(files)} files, {found} findings" + ("" if code == 0 else f"; see {log.relative_to(ROOT)}")


def coverage():
    """Lines of the kernels that their tests reach."""
    log = FOLDER / "coverage.log"
    log.unlink(missing_ok=True)
    package = build("coverage", "-O0 -g1 --coverage")
    if package is None:
        return False, f"does not build, see {log.relative_to(ROOT)}"
    objects = FOLDER / "coverage" / "build"
    for counts in objects.rglob("*.gcda"):
        counts.unlink()
    if run([*PYTEST, *WITHOUT_YADE, TESTS], log, cwd=ROOT, env=environment(package, OMP_NUM_THREADS="1")):
        return False, f"{last_line(log)}; see {log.relative_to(ROOT)}"
    told = subprocess.run(["gcovr", "--root", str(ROOT), "--filter", "pkg/kernel/", "--html-details", str(FOLDER / "coverage" / "index.html"), "--print-summary", str(objects)],
                          capture_output=True, text=True)  # fmt: skip
    log.write_text(log.read_text() + told.stdout + told.stderr)
    return told.returncode == 0, ", ".join(line for line in told.stdout.splitlines() if line.startswith(("lines:", "branches:"))) or last_line(log)


right, about = dict(tidy=tidy, coverage=coverage)[sys.argv[1]]()
print(about)
sys.exit(0 if right else 1)

"""Static analysis and coverage of the kernels: `analyze.py tidy` or `analyze.py coverage`.

check-in-debian runs it in an environment with clang-tidy and gcovr. The last line is the verdict.
"""

import subprocess
import sys

from check import FOLDER, PYTEST, ROOT, TESTS, WITHOUT_YADE, build, environment, last_line, run


def tidy(log):
    """clang-tidy on the kernels, with the checks of .clang-tidy."""
    folder = FOLDER / "tidy"
    configure = ["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", "-DRCR_PLUGIN=OFF",
                 "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON", f"-DRCR_PACKAGE={folder}"]
    if run(configure, log):
        return False, "does not configure"
    files = sorted(str(path) for path in (ROOT / "pkg" / "kernel").rglob("*.cpp"))
    command = ["clang-tidy", "-p", str(folder), "--quiet", "--warnings-as-errors=*", *files]
    code = run(command, log)
    lines = log.read_text(errors="replace").splitlines()
    found = sum(": warning:" in line or ": error:" in line for line in lines)
    return code == 0, f"{len(files)} files, {found} findings"


def coverage(log):
    """Lines of the kernels that their tests reach."""
    package = build("coverage", "-O0 -g1 --coverage")
    if package is None:
        return False, "does not build"
    objects = FOLDER / "coverage" / "build"
    for counts in objects.rglob("*.gcda"):
        counts.unlink()
    variables = environment(package, OMP_NUM_THREADS="1")
    if run([*PYTEST, *WITHOUT_YADE, TESTS], log, cwd=ROOT, env=variables):
        return False, last_line(log)
    command = ["gcovr", "--root", str(ROOT), "--filter", "pkg/kernel/", "--html-details",
               str(FOLDER / "coverage" / "index.html"), "--print-summary", str(objects)]
    done = subprocess.run(command, capture_output=True, text=True)
    log.write_text(log.read_text() + done.stdout + done.stderr)
    lines = done.stdout.splitlines()
    summary = ", ".join(line for line in lines if line.startswith(("lines:", "branches:")))
    return done.returncode == 0, summary or last_line(log)


name = sys.argv[1]
log = FOLDER / f"{name}.log"
log.unlink(missing_ok=True)
right, about = dict(tidy=tidy, coverage=coverage)[name](log)
print(about if right else f"{about}; see {log.relative_to(ROOT)}")
sys.exit(0 if right else 1)

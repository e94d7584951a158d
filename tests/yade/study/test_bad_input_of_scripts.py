"""Bad input of scripts: one clear line on stderr, a non-zero exit code, no result."""

import os

import forked
import pytest
from common import complaint

REFUSED = [
    *(("biaxial.py", *row) for row in (
        ("--eta 1", "eta = 1.0; expected an elongation 0 ≤ eta < 1"),
        ("--particles 3", "particles = 3; expected at least 10"),
        (f"--particles {'9' * 30}", "expected a whole number"),
        ("--particles abc", "--particles 'abc': expected a whole number"),
        ("--eta nan", "--eta nan: expected a finite number"),
        ("--time-step 1e6", "time_step = 1000000.0; expected a number > 0, at most 10"),
        ("--inertial-number 1e9", "is the strain of a step"),
        ("--threads 1000000", "threads = 1000000; expected 0 (as many as YADE uses)"),
        ("--seed -1", "seed = -1; expected a whole number ≥ 0"),
        ("--strain 1e-9", "--strain 1e-09: expected at least 0.001"),
        ("--networks 0", "--networks 0: expected at least 1"),
        ("--networks 11 --strain 0.01", "--networks 11 up to --strain 0.01: expected at most 10"),
        ("--iterations 1e3", "--iterations '1e3': expected a whole number"),
        ("--out=", "--out '': expected a path"),
        (f"--out {__file__}", "expected a folder for the results"),
        ("--friction -1", "friction = -1.0; expected a coefficient ≥ 0"),
        ("--strain 2", "--strain 2.0: expected 0 < strain < 1"),
        ("--solver magic", "solver = 'magic'; expected one of"),
        ("--shape square", "--shape invalid choice: 'square'"),
        ("--shape regular", "shape = 'regular' with sides = None; sides belong to"),
        ("--sides 5", "shape = 'rcr' with sides = 5; sides belong to the shape 'regular'"),
        ("--shape regular --sides 2", "sides = 2; expected a number of sides from 3 to 64"),
        ("--shape regular --sides 6 --eta 0.3", "6 sides have η = 1 − cos(π/6) = 0.1340"),
        ("--shape truncated --eta 0.1", "eta = 0.1 with shape = 'truncated'; expected 0.134 to 0.5"),
        ("--shape trimer --eta 0.6", "eta = 0.6 with shape = 'trimer'; expected 0 to 0.5"),
        ("--size-span 0.5", "size_span = 0.5; expected a ratio R_max/R_min from 1"),
        ("--shape trimer --rolling-friction 0.1", "expected shape = 'rcr', or no rolling friction"),
        ("--law smooth --rolling-friction 0.1", "expected law = 'cd', or no rolling friction"),
        ("--rolling-friction -1", "rolling_friction = -1.0; expected a coefficient ≥ 0"),
        ("--resume", "nothing to resume"))),
    *(("chart.py", "--quick " + arguments, message) for arguments, message in (
        ("--only x", "--only x: say which chart it is of"),
        ("--charts b --only x", "--only x: chart b has no such point; it has column/reference"),
        ("--particles 10", "--particles 10: expected at least 50"),
        (f"--particles {'9' * 20}", "expected at least 50"),
        ("--limit nan", "--limit nan: expected seconds > 0"),
        ("--limit 0", "--limit 0.0: expected seconds > 0"),
        (f"--out {__file__}", "is not a folder"))),
    ("bench_step.py", __file__, "is no folder"),
    ("bench_step.py", os.path.dirname(__file__), "nothing to resume"),
]


@pytest.mark.parametrize("script, arguments, message", REFUSED)
def test_one_line_says_what_is_wrong(script, arguments, message, tmp_path):
    done = forked.run(script, "--out", tmp_path / "out", *arguments.split())
    assert message in complaint(done)
    assert not (tmp_path / "out" / "summary.json").exists()

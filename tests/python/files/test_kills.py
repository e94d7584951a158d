"""A few kills of tests/endurance/kills.py."""

import random
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "endurance"))

import kills


def test_killed_writes_leave_whole_files(tmp_path):
    assert kills.kill_writes(25, tmp_path, random.Random(1)).startswith("25 SIGKILLs")

"""Benchmarks of speed, accuracy and stability, and the programs that run other libraries.

Entry points: `scripts/chart.py`, `scripts/hard_scenes.py` and `scripts/bench_*.py`.
`driven_scenes.py` runs as it is. The package `rcr` needs none of this.
"""

import os
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
sys.path.append(os.path.join(ROOT, "tests"))  # its modules `bodies` and `oracle`

"""Run with YADE by scripts/yade-rcr: the code is benchmarks/bench_problems.py."""

from benchmarks import bench_problems
from rcr import script

script.run(bench_problems.main)

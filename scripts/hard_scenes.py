"""Run with YADE by scripts/yade-rcr: the code is benchmarks/hard_scenes_table.py."""

from benchmarks import hard_scenes_table
from rcr import script

script.run(hard_scenes_table.main)

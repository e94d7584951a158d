#!/usr/bin/env python3
"""Entry point of benchmarks/bench_step.py, run by Python or by YADE."""

import os
import sys

sys.path.insert(0, os.path.dirname(os.path.realpath(sys.argv[0])))  # Python adds it, YADE does not
from lib import environment

environment.run("benchmarks.bench_step")

#!/usr/bin/env python3
"""Entry point of benchmarks/bench_solver.py."""

from lib import environment

from benchmarks import outside

environment.run("benchmarks.bench_solver", outside.stay)

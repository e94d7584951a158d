#!/usr/bin/env python3
"""Entry point of benchmarks/bench_solver.py."""

from lib import environment

environment.run("benchmarks.bench_solver")

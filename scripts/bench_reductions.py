#!/usr/bin/env python3
"""Entry point of benchmarks/bench_reductions.py."""

from lib import environment

environment.run("benchmarks.bench_reductions")

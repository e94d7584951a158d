#!/usr/bin/env python3
"""Entry point of benchmarks/chart.py."""

from lib import environment

from benchmarks import outside

environment.run("benchmarks.chart", outside.stay)

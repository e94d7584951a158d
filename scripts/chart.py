#!/usr/bin/env python3
"""Entry point of benchmarks/chart.py."""

from lib import environment

environment.run("benchmarks.chart")

"""The study of Azéma and Radjaï's paper: the biaxial test, its analysis, figures and report.

`scripts/biaxial.py`, `scripts/network.py`, `scripts/campaign` and the benchmarks use it; other
scenes do not need it.
"""

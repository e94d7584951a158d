"""The study of Azéma and Radjaï's paper: the biaxial test, the analysis of its force networks, figures and report.

A scene needs none of it; `scripts/biaxial.py`, `scripts/network.py` and `scripts/campaign` are its entry points.
"""

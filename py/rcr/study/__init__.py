"""The study of Azéma and Radjaï's paper: the biaxial test, its analysis, figures and report.

`scripts/biaxial.py`, `scripts/network.py` and `scripts/campaign` use it;
other scenes do not need it.
"""

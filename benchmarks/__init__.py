"""Speed, accuracy and stability, ours and others': charts, hard scenes, timing, peers' programs.

No part of the package `rcr`; the scripts `chart.py`, `hard_scenes.py`, `driven_scenes.py` and `bench_*.py` are its entry points.
"""

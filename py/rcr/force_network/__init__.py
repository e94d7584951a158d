"""Force networks of any scene: distributions, fabric, force chains and a report.

`scripts/network.py` uses it for networks that are no shear test. Needs NumPy, h5py and Matplotlib.
"""

#!/usr/bin/env python3
"""Make the packings under shear that tests solve.

    scripts/lib/run python3 tests/data/make_packings.py

Each is one step of a biaxial test after a few per cent of shear, as `ContactDynamics.save` writes
it.
"""

import pathlib
import sys

import yade  # noqa: F401  before rcr, which loads its plugin into it
from rcr.study.biaxial import Biaxial

STRAIN = 0.03
PACKINGS = [(500, 0.0), (500, 0.7), (1000, 0.0)]  # particles, elongation


def main():
    folder = pathlib.Path(__file__).parent
    for particles, eta in PACKINGS:
        test = Biaxial.prepare(eta=eta, particles=particles, seed=1, tolerance=1e-3)
        test.compact(balanced=0.01)
        while test.strain < STRAIN:
            test.shear_record()
        path = folder / f"shear-{particles}-eta-{eta:g}.npz"
        test.solver.save(str(path))
        print(f"{path.name}: {test.solver.contactPoints} contact points, strain {test.strain:.3f}, "
              f"{path.stat().st_size / 1e3:.0f} kB", flush=True)


if __name__ == "__main__":
    sys.exit(main())

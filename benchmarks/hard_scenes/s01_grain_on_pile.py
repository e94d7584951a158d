"""S1. A light grain lands on a settled pile of 234 heavy ones.

The pile meets a stop criterion over all contacts, although the impulse of the grain, 1e-3 of
theirs, is still wrong.
"""

import numpy as np
from yade import O

from .rest import BOUND, REASON
from .stage import D, R, build as scene, material, open_box, real_contacts, stadium

TITLE = "light grain lands on a settled pile"
PREDICATE = "deepest overlap of the grain, in its diameters"
COLUMNS, ROWS, SMALL = 20, 12, R / 5


def build(law, dt):
    rough = material()
    centers = [(R * (1 + row % 2) + D * k, R + row * np.sqrt(3) * R) for row in range(ROWS)
               for k in range(COLUMNS - row % 2)]
    discs = [stadium(0, R, c, material=rough) for c in centers]
    ids = scene(law, dt, *open_box(COLUMNS * D, rough), *discs)
    return ids[3:]


def measure(ids, clock):
    clock.pass_(0.2)
    top = R + (ROWS - 1) * np.sqrt(3) * R
    center = 0.4 * COLUMNS * D, top + 3 * R
    grain = O.bodies.append(stadium(0, SMALL, center, material=material()))
    worst = [0.0]

    def look():
        worst.extend(-gap for i in real_contacts() if grain in (i.id1, i.id2)
                     for gap in tuple(i.geom.gap)[:i.geom.points])

    clock.restart()
    clock.pass_(0.5, look)
    return max(worst) / (2 * SMALL)

"""S3. A dense box of 95 RCRs under a heavy lid, with a cold start.

The first step must find all forces; an error lets the lid sink.
"""

import rcr

from .rest import BOUND, REASON
from .stage import D, R, build as scene, material, open_box, positions, stadium

TITLE = "cold dense box under a heavy lid"
PREDICATE = "displacement of the lid in 1 s, in diameters"
ROWS, COLUMNS = 10, 10


def build(law, dt):
    rough = material()
    a = r = R / 2  # bricks of 2R by R, each on the ends of two
    bricks = [stadium(a, r, (R * (1 + row % 2) + D * k, r * (1 + 2 * row)), material=rough)
              for row in range(ROWS) for k in range(COLUMNS - row % 2)]
    mass = sum(b.state.mass for b in bricks)
    lid = rcr.mobile_wall("y", 2 * r * ROWS, mass, sense=-1, material=rough)
    ids = scene(law, dt, *open_box(COLUMNS * D, rough), lid, *bricks)
    return ids[3:4]


def measure(lid, clock):
    start = positions(lid)
    clock.pass_(1.0)
    return abs(positions(lid) - start).max() / D

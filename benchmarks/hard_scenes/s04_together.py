"""S4. The seven columns and the tower in one scene.

One stop criterion serves all: what 10⁶ times heavier neighbours leave of it for the tower.
"""

import rcr

from . import s04_mass_ratio, s04_tower
from .stage import build as scene, material

TITLE = "all mass ratios in one scene"
PREDICATE, BOUND, REASON = s04_tower.PREDICATE, s04_tower.BOUND, s04_tower.REASON
measure = s04_tower.measure


def build(law, dt):
    return scene(law, dt, rcr.wall("y", 0, material=material()), *s04_mass_ratio.columns(), *s04_tower.tower(-1.0))[1:]

"""S4. The seven columns and the tower in one scene.

One stop criterion serves all: neighbours 10⁶ times as heavy hide errors in the tower.
"""

from . import s04_mass_ratio, s04_tower
from .stage import material, on_floor

TITLE = "all mass ratios in one scene"
PREDICATE, BOUND, REASON = s04_tower.PREDICATE, s04_tower.BOUND, s04_tower.REASON
measure = s04_tower.measure


def build(law, dt):
    return on_floor(law, dt, material(), *s04_mass_ratio.columns(), *s04_tower.tower(-1.0))

"""S4. The seven columns and the tower in one scene.

One stop criterion serves all: neighbours 10⁶ times as heavy hide errors in the tower.
"""

from .rest import BOUND, PREDICATE, REASON, measure
from .s04_mass_ratio import columns
from .s04_tower import tower
from .stage import material, on_floor

TITLE = "all mass ratios in one scene"


def build(law, dt):
    return on_floor(law, dt, material(), *columns(), *tower(-1.0))

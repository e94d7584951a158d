"""S7. Eight long RCRs (η = 0.9) lie on each other.

If an angle decides between one point and two, rounding switches the second point on and off.
"""

import math

from .stage import D, R, X, material, on_floor, real_contacts, stadium, tilted

TITLE = "long parallel RCRs at rest"
PREDICATE = "steps of 1000 in which a contact changes its type or points"
BOUND = 0
REASON = "nothing moves, so no contact changes"
COUNT = 8


def long_stack(law, dt, mu_floor, gravity, count):
    rough = material()
    rods = [stadium(0.9 * R, 0.1 * R, (X, 0.1 * R * (1 + 2 * k)), material=rough)
            for k in range(count)]
    return on_floor(law, dt, material(mu_floor), *rods, gravity=gravity)


def build(law, dt):
    return long_stack(law, dt, 0.5, tilted(0), COUNT)


def kinds():
    """Type and points of the touching pairs; pairs with a gap depend on the speed."""
    return sorted((i.id1, i.id2, i.geom.type, i.geom.points) for i in real_contacts()
                  if min(i.geom.gap) < 1e-4 * D)


def measure(ids, clock):
    clock.step(1)
    last, changes = [kinds()], []

    def look():
        changes.append(kinds() != last[-1])
        last.append(kinds())

    clock.step(1000, look)
    complete = [points for *_, points in last[-1]] == [2] * len(ids)
    return sum(changes) if complete else math.inf

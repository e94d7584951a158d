"""S13. Newton's cradle: one of five discs in touch is hit, e = 1.

Newton's rule has no waves: all touching contacts get a share at once, and the last disc does not
get all. Energy and momentum must be conserved nevertheless.
"""

from .stage import D, R, build as scene, kinetic, material, stadium, state

TITLE = "Newton's cradle"
PREDICATE = "largest |kinetic energy / first − 1| in 0.5 s"
BOUND = 1e-3
REASON = "tolerance 1e-4 in each velocity, squared, over some impacts"
SPEED = 10 * R


def build(law, dt):
    smooth = material(0)
    discs = [stadium(0, R, (D * k - (R if k == 0 else 0), 0), material=smooth) for k in range(6)]
    ids = scene(law, dt, *discs, gravity=(0, 0, 0), restitution=1)
    state(ids[0]).vel = (SPEED, 0, 0)
    return ids


def measure(ids, clock):
    first, seen = kinetic(), []
    clock.pass_(0.5, lambda: seen.append(kinetic()))
    return max(abs(e / first - 1) for e in seen)

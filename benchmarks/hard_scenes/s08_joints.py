"""S8. A disc rolls over the joints of a floor of boxes.

The disc can touch the two corners of a joint only from above. A detector that treats them as
obstacles brakes the disc or makes it jump.
"""

from .stage import R, box, build as scene, material, stadium, state, twist

TITLE = "disc rolls over the joints of a floor"
PREDICATE = "largest |v/v₀ − 1| in 1 s and 8 joints"
BOUND = 1e-3
REASON = "rounding on a floor without joints; 1e-3, as in all scenes"
SPEED = 30 * R  # m/s


def build(law, dt):
    rough = material()
    floor = [box((4 * R * (k + 0.3), -R), (2 * R, R), material=rough) for k in range(-1, 11)]
    disc = scene(law, dt, *floor, stadium(0, R, (0, R), material=rough))[-1]
    state(disc).vel, state(disc).angVel = (SPEED, 0, 0), (0, 0, -SPEED / R)
    return disc


def measure(disc, clock):
    speeds = []
    clock.pass_(1.0, lambda: speeds.append(twist(disc)[0]))
    return max(abs(v / SPEED - 1) for v in speeds)

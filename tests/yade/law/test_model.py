"""`ContactDynamics.model` follows the scene: friction, a freed body, heaps that touch."""

from benchmarks.hard_scenes.stage import box, material, stadium
from scenes import build, solver, steps
from yade import O, utils


def heaps(count, friction):
    """Heaps of 5 × 4 discs side by side on a fixed floor, too far apart to touch."""
    one = material(friction=friction)
    build(box((count, -0.1), (2 * count, 0.1), material=one),
          *(stadium(0, 0.05, (2 * heap + 0.1 * column + 0.03 * (row % 2), 0.05 + 0.09 * row),
                    material=one)
            for heap in range(count) for row in range(4) for column in range(5)),
          tolerance=1e-6, maxIterations=5000, solver="nesterov")


def test_model_of_discs_without_friction():
    heaps(3, 0)
    steps(3)
    model = solver().model
    assert model["islands"] == 3 and model["fixed"] == 1
    assert model["bodies"] == 60 and model["rotations"] == 0
    assert model["frictionless"] and model["unknowns"] == model["points"] == solver().contactPoints


def test_model_follows_the_scene():
    """With friction a point has two unknowns, bodies rotate; a freed floor joins the heaps."""
    heaps(3, 0)
    steps(3)
    utils.setContactFriction(0.5)
    O.step()
    model = solver().model
    assert not model["frictionless"] and model["unknowns"] > model["points"]
    assert model["rotations"] > 0 and model["islands"] == 3
    O.bodies[0].dynamic = True
    O.bodies[0].state.blockedDOFs = "xzXYZ"
    O.bodies[0].state.mass = 100.0
    O.step()
    assert solver().model["fixed"] == 0 and solver().model["islands"] == 1

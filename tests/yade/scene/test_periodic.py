"""Periodic cells: images across the boundary, velocity gradient, stress, saves."""

import math

import numpy as np
import pytest
import rcr
from scenes import (LAWS, assert_refused, assert_reload_changes_nothing, build, exchange, gaps,
                    insert, kinetic, material, plane, refused, shrinking_cell, snapshot, solver,
                    springy, steps, warns, without)
from yade import O, utils
from yade.minieigenHP import Matrix3, Quaternion
from yade.wrapper import (InsertionSortCollider, Peri3dController, PeriIsoCompressor,
                          PeriTriaxController, PyRunner)


def scene(law, *bodies, size=2.0, gravity=(0, 0, 0), **options):
    return build(*bodies, cell=size, law=law, gravity=gravity, **options)


def pair(across, eta, m):
    """Two grains overlap, slide and turn against each other, about x = 1 or about x = 0 ≡ 2."""
    R, overlap = 0.25, 2**-7  # binary fractions: a shift by the cell is exact
    left, right = (2 - R, R - overlap) if across else (1 - R, 1 + R - overlap)
    return [rcr.particle((x, 1.0), R, eta, angle=angle, velocity=v, angular_velocity=w, material=m)
            for x, angle, v, w in ((left, 0.05, (0.3, 0.1), 2), (right, -0.02, (-0.2, -0.3), -1))]


@LAWS
@pytest.mark.parametrize("eta", [0, 0.5])
def test_pair_across_the_boundary_is_one_in_the_open(law, eta):
    def forces(across, size):
        scene(law, *pair(across, eta, springy()), size=size, dt=4e-3 if law == "rigid" else 1e-5)
        with warns("bodies #0 and #1 overlap"):
            return np.array([(O.step(), snapshot()[:, 7:])[1] for _ in range(10)])

    inside = forces(False, None)
    assert np.abs(inside[..., 6:]).max() > 1  # they push
    rounding = dict(rel=1e-12, abs=1e-12 * np.abs(inside).max())
    assert forces(True, 2.0) == pytest.approx(inside, **rounding)
    assert forces(False, 2.0) == pytest.approx(inside, **rounding)


@LAWS
def test_pair_in_a_sheared_cell_moves_with_the_image(law):
    """Two grains touch across the boundary in y; the upper image is faster by γ̇ L and drags."""
    m = springy()
    ids = scene(law, *(rcr.disc((1, y), 0.2, material=m) for y in (0.2, 1.8 + 1e-4)), dt=1e-5)
    O.cell.velGrad = plane(0, 0.5, 0, -0.1)
    steps(1 if law == "rigid" else 3)  # the rigid impact ends within one step
    (contact,) = O.interactions
    assert abs(contact.cellDist[1]) == 1
    forces = np.array([O.forces.f(k) for k in ids])
    assert np.abs(forces[:, :2].sum(axis=0)).max() < 1e-9 * np.abs(forces).max()
    assert forces[0][1] > 0 and forces[0][0] < 0 < forces[1][0]  # body 0 has the upper image


def packing(eta, columns=10):
    """Side of a cell, its material, and loose grains without friction on a square lattice."""
    rng, m, pitch = np.random.default_rng(2), material(friction=0.0), 0.135
    return columns * pitch, m, [
        rcr.particle((pitch * (i + 0.5), pitch * (j + 0.5)), 0.05 * rng.uniform(0.7, 1), eta,
                     angle=rng.uniform(0, 3), material=m)
        for i in range(columns) for j in range(columns)]  # fmt: skip


AUTO = dict(tolerance=1e-4, solver="auto", maxIterations=1000)


def fraction(m):
    """Packing fraction of the cell, whose grains have the material m."""
    area = sum(b.state.mass for b in O.bodies) / m.density
    return area / (O.cell.hSize[0, 0] * O.cell.hSize[1, 1])


@pytest.mark.parametrize("eta", [0, 0.5])
def test_strain_driven_compaction_holds_its_grains_apart_up_to_a_jam(eta):
    size, m, grains = packing(eta)
    scene("rigid", *grains, size=size, **AUTO)
    O.cell.velGrad = plane(-0.3, 0, 0, -0.3)
    while fraction(m) < 0.76:
        steps(50)
    assert solver().contactPoints > 50 and min(gaps()) > -0.01 * 0.1
    if eta == 0:
        solver().maxIterations = 500
        refused("jam.*the velocity gradient of the cell", steps, 3000, error=RuntimeError)


def test_a_body_is_erased_from_a_cell_only_with_a_new_collider():
    """YADE's collider hangs after an erase in a cell that has shrunk."""
    m = springy()
    scene("rigid", *[rcr.particle((0.25 * (i + 0.5), 0.25 * (j + 0.5)), 0.1, 0.4, i, m)
                     for i in range(8) for j in range(8)], tolerance=1e-4)
    O.bodies.erase(3)  # the collider has not run
    O.cell.velGrad = plane(-0.5, 0, 0, -0.5)
    O.run(250, True)
    O.cell.velGrad = Matrix3.Zero
    refused("body #9 .* put a new InsertionSortCollider into O.engines first", O.bodies.erase, 9)
    assert O.bodies[9] is not None
    exchange(InsertionSortCollider([rcr.Bo1_Rcr_Aabb()], verletDist=0.01))
    O.bodies.erase(9)
    for body in O.bodies:
        body.state.vel = (10, 3, 0)
    O.run(500, True)
    assert O.iter == 750 and np.isfinite(rcr.measure.extent()).all()


@pytest.mark.parametrize("strain, eta", [(5e-3, 0), (1e-3, 0.7), (2e-4, 0.95)])
@pytest.mark.parametrize("corner", [False, True])
def test_images_meet_that_only_the_cell_brings_together(strain, eta, corner):
    """Two grains are at rest; the image of the lower one comes by the motion of the cell alone."""
    R, dt = 0.1, 1e-2
    lower, upper = scene("rigid", *(rcr.particle((1, y), R, eta, material=material(0))
                                    for y in (0.1, 1.5)), dt=dt)
    O.cell.velGrad = plane(-strain / dt if corner else 0, 0, 0, -strain / dt)
    steps(1)
    width = 2 * R * (1 - eta)
    # YADE shrinks the cell before the contacts of a step are detected
    edge = O.cell.hSize[1, 1] * (1 - strain) ** 2  # at the end of the next step
    start = O.bodies[lower].state.pos
    O.bodies[upper].state.pos = (start[0], start[1] + edge - width + 0.6 * strain * edge, 0)
    O.bodies[lower].state.vel = O.bodies[upper].state.vel = (0, 0, 0)
    steps(1)
    gap = O.bodies[lower].state.pos[1] + edge - O.bodies[upper].state.pos[1] - width
    assert solver().converged and gap == pytest.approx(0, abs=1e-5 * R)


@pytest.mark.parametrize("homo_deform, dt, stress", [(0, 1e-2, None), (2, 1e-3, 100)])
def test_a_loose_cell_closes_without_overlaps(homo_deform, dt, stress):
    """By prescribed motion, which may leave the grains at rest, and by a stress."""
    size, m, grains = packing(0.5)
    scene("rigid", *grains, size=size, dt=dt, **AUTO)
    O.cell.homoDeform = homo_deform
    O.cell.velGrad = plane(-0.3, 0.1, 0, -0.3)
    if stress:
        insert(3, rcr.CellStress(stress=(stress, stress)))
    while fraction(m) < 0.72:
        steps(5)
    assert solver().deepestOverlap < 1e-3 and solver().missedSteps == 0


def pressed(*bodies, stress, mass=1, **options):
    """A scene of these bodies, if any, and a stress on its cell."""
    if bodies:
        scene("rigid", *bodies, **options)
    insert(3, rcr.CellStress(stress=stress, mass=mass))


def test_a_reload_continues_to_the_same_bits(tmp_path):
    size, m, grains = packing(0.5, columns=7)
    pressed(*grains, size=size, stress=(math.nan, 50), **AUTO)
    O.cell.velGrad = plane(-0.3, 0.2, 0, -0.3)
    steps(700)
    assert_reload_changes_nothing(tmp_path / "cell.yade", lambda: (
        steps(100), snapshot().tolist(), np.array(O.cell.hSize).tolist()))


def test_problems_of_a_deforming_cell_are_not_saved(tmp_path):
    """Files have no velocities of images, so their solution would be another."""
    shrinking_cell()
    path = str(tmp_path / "problem.npz")
    refused("the periodic cell deforms", solver().save, path)
    O.cell.velGrad = Matrix3.Zero
    O.step()
    solver().save(path)
    assert rcr.problems.load(path).contacts == solver().contactPoints > 0


@pytest.mark.parametrize("fault, match", [
    (lambda: O.bodies.append(rcr.wall("y", 0, material=O.bodies[0].material)),
     "#1 is a Wall in a periodic cell, which has no boundary"),
    (lambda: (steps(5), setattr(O.cell, "velGrad", plane(0, math.nan, 0, 0))),
     "O.cell.velGrad is not finite"),
    (lambda: (steps(1), setattr(O.cell, "hSize", Matrix3(2, 8, 0, 0, 2, 0, 0, 0, 2))),
     r"sheared, so that radii count [89][\d.]* times: O\.cell\.flipCell"),
    (lambda: (O.bodies.append(utils.box((1, 0.2, 0), (0.1, 0.1, 0.1), fixed=True)), steps(1),
              setattr(O.cell, "velGrad", plane(0, 0.1, 0, 0))),
     "#1 is a Box in a sheared periodic cell; use rcr.segment or fixed grains"),
    (lambda: scene("rigid", rcr.disc((0.3, 0.3), 0.2, material=material()), size=0.7),
     "the periodic cell is 0.7 wide at its narrowest, body #0 has the radius 0.2"),
    (lambda: O.bodies.append(rcr.segment((0.4, 1), (1, 1))),
     "the periodic cell is 2 wide at its narrowest, body #1 has the radius 0.6"),
    (lambda: insert(3, PeriTriaxController(dynCell=True, mass=1, goal=(-1, -1, 0), stressMask=3)),
     "PeriTriaxController moves the cell .* use rcr.CellStress"),
    (lambda: insert(3, PeriIsoCompressor(stresses=[-1])), "PeriIsoCompressor .* rcr.CellStress"),
    (lambda: insert(3, Peri3dController(goal=(-1, -1, 0, 0, 0, 0), stressMask=3)),
     "Peri3dController .* rcr.CellStress"),
    (lambda: pressed(stress=(1, 1), mass=0), "CellStress.mass = 0; expected a finite factor > 0"),
    (lambda: pressed(stress=(math.inf, 0)), "CellStress.stress is infinite"),
    (lambda: pressed(rcr.disc((1, 1), 0.3), size=None, stress=(1, 1)),
     "CellStress has no cell to press"),
    *((lambda homo=homo: (pressed(stress=(1, 1)), setattr(O.cell, "homoDeform", homo)),
       f"CellStress moves the bodies with the cell, and O.cell.homoDeform = {homo}; expected 2")
      for homo in (0, 1)),
    (lambda: (scene("smooth", rcr.disc((1, 1), 0.3)), pressed(stress=(1, 1))),
     "contacts are springs; take PeriTriaxController"),
])  # fmt: skip
def test_faults_of_a_cell(fault, match):
    scene("rigid", rcr.particle((0.3, 1), 0.3, 0.5, material=material()))
    fault()
    assert_refused(match)


def test_a_step_that_may_meet_two_images_has_not_converged():
    """A pair has one contact, so the overlap with its other image would be silent."""
    for speed, missed in ((100, 0), (200, 1)):
        fast = rcr.particle((0.5, 0.5), 0.1, 0.5, material=material(), velocity=(speed, 0))
        scene("rigid", fast, rcr.disc((1.5, 1.5), 0.1, material=fast.material), dt=5e-3)
        steps(1)
        assert solver().missedSteps == missed


@pytest.mark.parametrize("gradient", [Matrix3.Zero, plane(-0.1, 0.3, 0, 0.1)],
                         ids=["still", "sheared"])
@pytest.mark.parametrize("settled", [2, 3, 4])
def test_a_velocity_set_between_steps_meets_far_contacts(settled, gradient):
    """It stops at another one three radii away."""
    R, m = 0.1, material(0)
    hit, other = scene("rigid",
                       *(rcr.particle((x, 1), R, 0, material=m) for x in (0.4, 0.4 + 5 * R)),
                       dt=5e-3, restitution=0)
    O.cell.velGrad = gradient
    steps(settled)
    O.bodies[hit].state.vel = (100, 0, 0)
    steps(1)
    way = [O.bodies[i].state.pos[0] for i in (hit, other)]
    assert way[1] - way[0] == pytest.approx(2 * R, abs=0.02 * R)  # after a way of 60 m/s
    assert O.bodies[other].state.vel[0] == pytest.approx(20, abs=0.5)


@pytest.mark.parametrize("shear, gap, speed, drifted", [
    (0, 0.4, 0.09, 60), (0.5, 0.24, 0.07, 55), (0.5, 0.26, 0.08, 55),
])
def test_a_body_that_has_drifted_in_its_box_meets_contacts(shear, gap, speed, drifted):
    """Discs drift and then approach each other by ±`speed` R a step; gaps are in R."""
    R, m = 0.01, material(0)
    along = np.array([1, -shear]) / math.hypot(1, shear)
    drift = 0.002 * (along if shear == 0 else np.array([-along[1], along[0]]))
    at = np.outer([-1, 1], (1 + gap / 2) * R * along) + [0.15, 0.1]
    scene("rigid", *(rcr.particle(tuple(x), R, 0, material=m) for x in at), size=0.2)
    O.cell.hSize = Matrix3(0.2, 0.2 * shear, 0, 0, 0.2, 0, 0, 0, 0.2)
    collider = next(e for e in O.engines if isinstance(e, InsertionSortCollider))
    collider.verletDist = 0.1 * R
    for count, closing in ((6, 0), (drifted, 0 if shear else 0.002), (4, speed)):
        for sign, body in zip((1, -1), O.bodies):
            body.state.vel = (*R / O.dt * (sign * closing * along + (drift if shear else 0)), 0)
        steps(count)
    assert solver().deepestOverlap < 1e-3


@pytest.mark.parametrize("size, shear", [(None, 0), (2, 0), (2, 0.5)])
def test_grains_at_rest_need_no_collider(size, shear):
    """Rounding would otherwise let about half of them leave their boxes."""
    m, rng = material(), np.random.default_rng(4)
    scene("rigid", *(rcr.particle((0.2 * i + 0.01 * rng.uniform(), 0.2 * j), 0.05, 0.3, fixed=True,
                                  material=m) for i in range(10) for j in range(10)), size=size)
    if size:
        O.cell.hSize = Matrix3(2, 2 * shear, 0, 0, 2, 0, 0, 0, 2)
    collider = next(e for e in O.engines if isinstance(e, InsertionSortCollider))
    steps(2)
    before = collider.numAction
    steps(20)
    assert collider.numAction == before


def pressed_row(size):
    """Ten discs of R = 0.1 that fill the cell along x, which a stress presses."""
    pressed(*[rcr.disc((size / 10 * (k + 0.5), 1), 0.1, material=material()) for k in range(10)],
            size=size, stress=(50, math.nan), tolerance=1e-8, maxIterations=5000)


def falling_disc(at, below, law="rigid"):
    """A disc without weight that falls at 1 m/s onto a fixed disc; R = 0.01 m, side 0.2 m."""
    m = springy(0)
    scene(law, rcr.disc(below, 0.01, m, fixed=True), rcr.disc(at, 0.01, m, velocity=(0, -1)),
          size=0.2, dt=1e-3 if law == "rigid" else 1e-5)
    O.engines[1].verletDist = 0.001


def flip(shear=0.8):
    O.cell.hSize = Matrix3(0.2, 0.2 * shear, 0, 0, 0.2, 0, 0, 0, 0.2)
    steps(1)
    O.cell.flipCell()


@LAWS
@pytest.mark.parametrize("clear", [flip, lambda: setattr(O, "periodic", False)],
                         ids=["flip", "O.periodic = False"])
def test_discs_meet_after_an_erasure_although_yade_clears_the_collider(clear, law):
    """After an erasure, YADE's collider would then list new bodies only."""
    falling_disc((0.05, 0.15), (0.05, 0.05), law)
    O.bodies.erase(O.bodies.append(rcr.disc((0.15, 0.15), 0.01)))
    steps(5)
    clear()
    while O.time < 0.12:
        steps(100 if law == "smooth" else 1)
    assert O.bodies[1].state.pos[1] > 0.069


def test_a_script_sets_how_a_cell_moves_its_bodies_after_steps_without_inertia():
    scene("rigid", rcr.disc((1, 1), 0.1), overdamped=True)
    steps(2)
    solver().overdamped = False
    O.cell.homoDeform = 1
    steps(1)
    assert O.cell.homoDeform == 1


@pytest.mark.parametrize("obstacle", [
    lambda: utils.wall((0, 0, 5), 2), lambda: rcr.segment((0.2, 0.1), (0.5, 0.3)),
    lambda: utils.box((0, 0, 0.01), (0.1, 0.1, 0.03), Quaternion((0, 0, 1), 0.3), fixed=True),
], ids=["wall parallel to the plane", "segment", "box that ends in the plane"])
def test_obstacles_at_rest_need_no_collider(obstacle):
    build(rcr.disc((1, 1, -0.02), 0.1, material()), gravity=(0, 0, 0))
    O.bodies.append(obstacle())
    steps(2)
    before = O.engines[1].numAction
    steps(20)
    assert O.engines[1].numAction == before


@pytest.mark.parametrize("gap, verlet, inserted", [
    (0, 0.001, False), (1e-3, 0.001, False), (4e-3, 0.001, False), (0, 0.001, True), (0, 0, True)])
def test_a_grain_that_a_script_wraps_keeps_its_contact(gap, verlet, inserted):
    """The collider lists its pair at the image of before; with a new body, it runs again."""
    falling_disc((0.1, 0.015 + gap), (0.1, -0.005))
    O.bodies[1].state.vel = (0, 0, 0)
    O.engines[1].verletDist = verlet
    O.engines[-1].gravity = (0, -9.81, 0)
    steps(30)
    O.bodies[0].state.pos = O.cell.wrap(O.bodies[0].state.pos)
    if inserted:
        O.bodies.append(rcr.disc((0.02, 0.1), 0.01, material(0)))
    O.run(60, True)
    assert O.bodies[1].state.pos[1] == pytest.approx(0.015, abs=1e-4)


@pytest.mark.parametrize("change", [
    lambda: exchange(rcr.ContactDynamics()), lambda: setattr(solver(), "overdamped", False),
    lambda: (O.saveTmp(), O.loadTmp(), exchange(rcr.ContactDynamics())),
], ids=["new engine", "overdamped=False", "new engine after a reload"])
def test_a_cell_moves_its_bodies_again_after_steps_without_inertia(change):
    """The mean flow of a shear at 0.5/s moves two discs at y = 0.05 and 0.15 m."""
    m = material(0)
    scene("rigid", *(rcr.disc((0.1, y), 0.01, m) for y in (0.05, 0.15)), size=0.2, overdamped=True)
    O.engines[1].verletDist = 0.001
    steps(5)
    assert O.cell.homoDeform == 0
    change()
    O.cell.velGrad = plane(0, 0.5, 0, 0)
    steps(10)
    assert O.cell.homoDeform == 2 and "rcr.homoDeform" not in O.tags.keys()
    assert O.bodies[1].state.vel[0] - O.bodies[0].state.vel[0] == pytest.approx(0.05)


@pytest.mark.parametrize("e", [0, 0.2, 0.9])
def test_two_discs_rebound_across_the_edge_of_a_pressed_cell(e):
    """The stress is 0, so the stretch rate g is that of the impact; u_n⁺ = −e u_n⁻."""
    m = material(0)
    pressed(rcr.disc((2 - 0.105, 1), 0.1, m, velocity=(1, 0)),
            rcr.disc((0.105, 1), 0.1, m, velocity=(-1, 0)), stress=(0, math.nan), restitution=e)
    steps(6)
    one, two = (body.state.vel[0] for body in O.bodies)
    assert (two - one + 2 * O.cell.velGrad[0, 0]) / 2 == pytest.approx(e, abs=1e-9)


@pytest.mark.parametrize("overdamped", [False, True])
def test_a_flipped_cell_answers_a_stress_as_before(overdamped):
    """YADE's flip chooses other edges of the same lattice, here a first edge with a slope."""
    def rates(flip):
        discs = [rcr.disc((0.1 + 0.15 * k, 0.05), 0.05, material()) for k in range(4)]
        scene("rigid", *discs, overdamped=overdamped, tolerance=1e-10)
        O.cell.hSize = Matrix3(1, 0.6, 0, 0, 0.6, 0, 0, 0, 2)
        pressed(stress=(10, 10))
        if flip:
            O.cell.flipCell()
            assert O.cell.hSize[1, 0] != 0
        steps(20)
        return O.cell.velGrad[0, 0], O.cell.velGrad[1, 1]

    assert rates(True) == pytest.approx(rates(False), rel=1e-6)


@pytest.mark.parametrize("overdamped", [False, True])
def test_a_cell_shears_its_grains_after_a_compression(overdamped):
    """CellStress, and steps without inertia, take over the mean flow only while they act."""
    upper, lower = (rcr.disc((1, y), 0.1, material()) for y in (0.5, 1.5))
    scene("rigid", upper, lower, overdamped=overdamped)
    if not overdamped:
        pressed(stress=(1, 1))
    steps(1)
    solver().overdamped = False
    without(rcr.CellStress)
    O.cell.velGrad = plane(0, 0.5, 0, 0)
    steps(2)
    assert O.bodies[1].state.vel[0] - O.bodies[0].state.vel[0] == pytest.approx(0.5, rel=1e-3)


def test_row_of_discs_carries_the_stress_of_its_cell():
    pressed_row(2.0)
    for _ in range(3):
        O.step()
        forces = [abs(i.phys.normalForce[0]) for i in O.interactions]
        assert len(forces) == 10 and forces == pytest.approx([50 * 2.0] * 10, rel=1e-5)
    assert abs(O.cell.velGrad[0, 0]) < 1e-8
    R, size = 0.1, 1.996
    pressed_row(size)
    steps(800)
    assert min(gaps()) > -2e-4 * 2 * R
    assert O.cell.hSize[0, 0] == pytest.approx(20 * R, rel=2e-4)
    assert O.cell.trsf[0, 0] == pytest.approx(O.cell.hSize[0, 0] / size, rel=1e-12)


@pytest.mark.parametrize("places, blocked, mass", [((0.5, 1.5), "z", 2), ((1,), "xz", 1),
                                                   ((1,), "yz", 1)])
def test_empty_cell_falls_together_as_a_body_of_its_mass(places, blocked, mass):
    """Also with the mass of grains that move along one axis only."""
    size, dt = 2.0, 1e-3
    grains = [rcr.disc((x, x), 0.1, material=material()) for x in places]
    for grain in grains:
        grain.state.blockedDOFs = blocked + "XY"
    pressed(*grains, size=size, stress=(3, 5), mass=mass, dt=dt)
    steps(1)
    inertia = mass * sum(grain.state.mass for grain in grains) * size**2 / 12
    assert [O.cell.velGrad[k, k] for k in range(2)] == pytest.approx(
        [-stress * size**2 * dt / inertia for stress in (3, 5)], rel=1e-12)
    assert O.cell.velGrad[0, 1] == O.cell.velGrad[2, 2] == 0
    for grain in grains:
        assert [grain.state.vel[k] for k in range(2)] == pytest.approx(
            [O.cell.velGrad[k, k] * grain.state.pos[k] for k in range(2)], rel=1e-2)


@pytest.mark.parametrize("eta", [0, 0.5])
def test_grains_come_to_rest_under_the_stress_of_their_cell(eta):
    """Contracted until they touch, then pressed without inertia."""
    size, m, grains = packing(eta)
    stress, mass = 100.0, np.mean([b.state.mass for b in grains])
    dt = 0.1 * math.sqrt(mass / stress)
    pressed(*grains, size=size, stress=(math.nan, math.nan), mass=12 / len(grains), dt=dt,
            tolerance=1e-6, solver="auto", maxIterations=3000)
    solver().overdamped = True
    O.cell.velGrad = plane(-0.004 / dt, 0, 0, -0.004 / dt)
    while fraction(m) < 0.7:
        steps(5)
    places = np.array([b.state.pos for b in O.bodies])[:, :2] / O.cell.size[0]
    assert np.abs(places - 0.5).max() < 0.6  # moved with the cell, none thrown out
    O.cell.velGrad, O.engines[3].stress = Matrix3.Zero, (stress, stress)
    steps(200)
    O.dt = 5 * dt
    steps(300)
    overlap = max(-i.geom.gap[k] / (i.geom.refR1 + i.geom.refR2) for i in O.interactions
                  for k in range(i.geom.points))
    assert 0.78 < fraction(m) < 0.92 and overlap < 1e-3
    assert np.diag(rcr.contact_network().stress()) == pytest.approx([stress] * 2, rel=0.02)


@pytest.mark.parametrize("overdamped", [True, False])
def test_a_loose_cell_that_falls_together_in_a_step_is_refused(overdamped):
    """16 loose discs must not shrink a cell of 0.09 to a quarter and pass through each other."""
    grid = [rcr.disc((0.0225 * (i + 0.5), 0.0225 * (j + 0.5)), 0.01, material(0)) for i in range(4)
            for j in range(4)]
    t0 = math.sqrt(grid[0].state.mass / 1e3)
    pressed(*grid, size=0.09, stress=(1e3, 1e3), mass=1e-3, dt=t0)
    O.engines[1].verletDist = 1e-3
    solver().overdamped = overdamped
    before = O.cell.hSize
    refused("CellStress would stretch the cell by .* % along x in step .*Nothing has moved. Set a "
            "smaller O.dt", steps, 5, error=RuntimeError)
    assert abs((O.cell.hSize - before)[0, 0]) < 0.05 * 0.09 and O.iter < 5


@pytest.mark.parametrize("shear", [0, 0.9])
def test_boxes_of_fast_bodies_fit_a_cell(shear):
    """At γ = 0.9 boxes are wider by 40 %; YADE's collider would end the process."""
    m = material()
    fast = rcr.particle((0.3, 1), 0.1, 0.5, material=m, velocity=(200, 0))
    _, disc = scene("rigid", fast, rcr.disc((1.5, 1), 0.1, material=m), dt=5e-3)
    O.cell.hSize = Matrix3(2, 2 * shear, 0, 0, 2, 0, 0, 0, 2)
    steps(20)
    assert O.bodies[disc].state.vel[0] > 50  # hit, not passed


def test_energy_of_a_cell_that_is_driven_closes():
    size, m, grains = packing(0.5)
    m.frictionAngle = 0.4
    scene("rigid", *grains, size=size, **AUTO | dict(accuracy=3e-4))
    O.cell.homoDeform = 0
    O.trackEnergy = True
    O.cell.velGrad = plane(-0.3, 0.1, 0, -0.3)
    while fraction(m) < 0.72:
        steps(50)
    totals = []
    for _ in range(9):  # O.energy holds the impacts of a step after the next one
        steps(1)
        accounts = dict(O.energy.items())
        # YADE counts velocities relative to those of the cell
        totals.append(kinetic() + sum(accounts.values()) - accounts.get("kinetic", 0))
    assert accounts["driveWork"] < 0 < accounts["plastDissip"]
    assert abs(np.median(totals)) < 0.002 * abs(accounts["driveWork"]), (totals, accounts)


@pytest.mark.parametrize("e", [0, 0.5, 0.9])
def test_the_stress_of_a_cell_is_no_impact(e):
    """Five discs that touch bear σ L at any restitution, from the first step on."""
    pressed(*[rcr.disc((0.2 + 0.4 * k, 1), 0.2, material()) for k in range(5)],
            stress=(100, math.nan), tolerance=1e-10, maxIterations=5000, restitution=e)
    forces = []
    for _ in range(20):
        steps(1)
        forces += [i.phys.normalForce.norm() for i in O.interactions if i.isReal]
    assert forces == pytest.approx([200] * 100, rel=1e-4)


@pytest.mark.parametrize("homo_deform", [1, 2])
def test_a_new_motion_of_the_cell_is_no_impact(homo_deform):
    """Gaps of 2 % are four steps wide; the mean field closes all of them alike."""
    m = material()
    scene("rigid", *(rcr.disc((0.25 * i + 0.125, 0.25 * j + 0.125), 0.1245, m)
                     for i in range(8) for j in range(8)), restitution=0.9)
    O.cell.homoDeform = homo_deform
    O.cell.velGrad = plane(-1, 0, 0, -1)
    steps(1)
    assert not any(i.phys.normalForce.norm() for i in O.interactions if i.isReal)
    assert max(O.cell.getFluctuationVelocity(b).norm() for b in O.bodies) < 5e-3


def test_a_new_time_step_keeps_the_images_of_a_moving_cell():
    """YADE moves the cell by the new step, after the bodies have moved by the old one."""
    m = material(0)
    scene("rigid", *(rcr.disc((x, 1), 0.125, m) for x in (0.2, 1.5)), dt=1e-4)
    O.cell.homoDeform = 0
    O.cell.velGrad = plane(-0.5, 0, 0, 0)
    while not len(list(O.interactions)):
        steps(100)
    steps(100)
    width = O.cell.hSize[0, 0]
    O.dt = 5e-3
    steps(2)
    assert solver().deepestOverlap < 1e-6
    assert O.cell.hSize[0, 0] == pytest.approx(width * (1 - 5e-5) * (1 - 2.5e-3), rel=1e-9)
    insert(5, PyRunner(command="O.dt /= 2", iterPeriod=1, nDo=1))
    refused("O.dt changed after ContactDynamics .* or the cell moved by another step", steps, 2)


@pytest.mark.parametrize("blocked", ["xyzXYZ", "xzXYZ"])
def test_grains_that_cannot_yield_to_the_stress_of_a_cell_are_refused(blocked):
    m = material(0)
    held = [rcr.disc((x, 1), 0.2, m) for x in (0.3, 1.6)]
    for grain in held:
        grain.state.blockedDOFs = blocked
    pressed(*held, *(rcr.disc((x, 0.4), 0.1, m) for x in (0.5, 1.5)), stress=(100, math.nan))
    refused("CellStress presses bodies #0 and #1 against each other, and", O.run, 2000, True,
            error=RuntimeError)
    apart = O.bodies[1].state.pos[0] - O.bodies[0].state.pos[0]
    assert O.cell.hSize[0, 0] - apart < 0.42  # they were let meet


@LAWS
def test_discs_meet_at_another_image_than_the_collider_listed(law):
    """The pair is always listed, at the image at which its boxes met first."""
    m = springy(0, young=1e8)
    rigid = law == "rigid"
    speed = 0.97 if rigid else 0.2
    scene(law, rcr.disc((0.0905, 0.2), 0.1, m, velocity=(-speed, 0)),
          rcr.disc((0.3095, 0.2), 0.1, m, velocity=(speed, 0)), size=0.46,
          dt=1e-2 if rigid else 1e-4)
    O.engines[1].verletDist = 0.005
    for body, force in (0, -1), (1, 1):
        O.forces.setPermF(body, (force, 0, 0))
    O.run(100 if rigid else 3000, True)
    apart = O.bodies[1].state.pos[0] - O.bodies[0].state.pos[0]
    assert 0.46 - apart > 0.19


def test_bodies_too_large_for_their_cell_are_refused():
    m = material(0)
    scene("rigid", size=0.2)
    rcr.clump([rcr.disc((0.01 + 0.018 * k, 0.1), 0.01, m) for k in range(10)])
    O.engines[1].verletDist = 1e-3
    O.cell.velGrad = plane(-1, 0, 0, 0)
    refused("the clump body #10 is up to 0.182 long and the periodic cell is 0.18", O.run, 200,
            True, error=RuntimeError)
    scene("rigid", rcr.disc((0.2, 0.2), 0.02, m), size=0.4)
    O.bodies.append(utils.box((0.2, 0.05, 0), (0.05, 0.02, 0.5), fixed=True))
    O.engines[1].verletDist = 2e-3
    refused("body #1 is a Box with the half width 0.5 along z in a periodic cell of the depth 0.4",
            steps, 1)
    O.cell.setBox(0.4, 0.4, 4)
    steps(1)
    scene("rigid", rcr.disc((0.5, 0.5), 0.19, m), size=1)
    O.engines[1].verletDist = -0.5
    refused("a verletDist of 0.095", steps, 1)


@LAWS
def test_the_far_end_of_a_triangle_stops_a_disc(law):
    """The middle of its segment is nearer to the disc than the centre of the triangle."""
    m = springy(0)
    corners = [(0, 0.5, -0.01), (0, 0.5, 0.01), (0.45, 0.5, 0)]
    scene(law, utils.facet(corners, material=m), rcr.disc((0.68, 0.5), 0.2, m, velocity=(-0.2, 0)),
          size=1.0, dt=1e-3 if law == "rigid" else 1e-5)
    O.engines[1].verletDist = 0.005
    while O.time < 0.3:
        O.run(100, True)
        assert O.bodies[1].state.pos[0] > 0.64


def test_a_new_time_step_after_a_refused_step_keeps_the_cell():
    """The next run finishes the refused step, for which the cell has moved already."""
    m = material(0)
    pressed(*(rcr.disc((0.4 * i + 0.2, 0.4 * j + 0.2), 0.15, m) for i in range(5)
              for j in range(5)), stress=(100, 100), mass=0.1, dt=1e-3)
    steps(20)
    O.engines[3].mass = 1e-6
    refused("CellStress would stretch the cell", O.run, 5, True, error=RuntimeError)
    before, step = O.cell.hSize[0, 0], O.cell.velGrad[0, 0] * O.dt
    O.engines[3].mass, O.dt = 0.1, 1e-6
    steps(1)
    assert abs(O.cell.hSize[0, 0] / before - 1) < 0.1 * abs(step)


def strains(shift=(0, 0), cells=0, wrap=False, overdamped=False, held=False):
    """Strains, work on the cell and unbalanced force under stress and shear.

    All grains are moved by `shift` [m]. Every second grain lies `cells` edges further along x;
    `held`: four grains are fixed.
    """
    rng, pitch = np.random.default_rng(3), 0.21
    size = 5 * pitch
    grains = []
    for k in range(25):
        at = np.array([pitch * (k // 5 + 0.5), pitch * (k % 5 + 0.5)]) + shift
        at = (at % size if wrap else at) + (cells * size * (k % 2), 0)
        grains.append(rcr.particle(tuple(at), rng.uniform(0.08, 0.1), 0.3, rng.uniform(0, 3),
                                   material(0.3), fixed=held and k % 7 == 2))
    pressed(*grains, size=size, stress=(100, 100), dt=2e-2 if overdamped else 2e-3,
            tolerance=1e-10, overdamped=overdamped)
    O.cell.velGrad = plane(0, 0.05, 0, 0)
    O.trackEnergy = True
    steps(60)
    return [*(O.cell.hSize[k, k] / size - 1 for k in (0, 1)), O.energy["driveWork"],
            solver().unbalancedForce]


@pytest.mark.parametrize("overdamped", [False, True])
@pytest.mark.parametrize("place, error", [
    (dict(cells=1), 1e-9), (dict(cells=20), 1e-9), (dict(shift=(0.4, 0.2)), 1e-7),
    (dict(shift=(0.4, 0.2), wrap=True), 1e-7), (dict(shift=(1000.1, -50.7)), 1e-7)], ids=str)
def test_a_stress_does_not_depend_on_images_and_the_edge(place, error, overdamped):
    for held in {False, not overdamped and "shift" in place}:
        expected = strains(overdamped=overdamped, held=held)
        assert min(expected) < -0.01  # it deforms
        moved = strains(**place, overdamped=overdamped, held=held)
        assert moved == pytest.approx(expected, rel=error)


@pytest.mark.parametrize("eta", [0, 0.5])
def test_elastic_grains_under_a_stress_keep_their_enthalpy(eta):
    """Energies of fluctuations and of the cell, plus σ V, where a gas first expands by half.

    The work on the cell is what the fluctuations lose.
    """
    rng, pitch, columns, stress, m = np.random.default_rng(1), 0.25, 6, 200, material(0)
    pressed(*(rcr.particle((pitch * (k // columns + 0.5), pitch * (k % columns + 0.5)),
                           0.1 * rng.uniform(0.8, 1), eta, rng.uniform(0, 3), m,
                           velocity=tuple(rng.normal(0, 1, 2))) for k in range(columns**2)),
            size=columns * pitch, stress=(stress, stress), dt=5e-4, tolerance=1e-9,
            maxIterations=5000, restitution=1)
    mass = sum(b.state.mass for b in O.bodies)

    def energies():
        size = np.diag(O.cell.hSize)[:2]
        fluctuations = sum(0.5 * b.state.mass * O.cell.getFluctuationVelocity(b).squaredNorm()
                           + 0.5 * b.state.inertia[2] * b.state.angVel[2] ** 2 for b in O.bodies)
        return fluctuations, (0.5 * mass / 12 * (size * np.diag(O.cell.velGrad)[:2]) ** 2).sum() \
            + stress * size.prod()  # fmt: skip

    O.trackEnergy = True
    found = []
    for _ in range(10):
        steps(400)
        fluctuations, cell = energies()
        found.append([fluctuations + cell,
                      fluctuations + O.energy["driveWork"] + O.energy["impactDissip"]])
    assert (np.ptp(found, axis=0) < (0.005, 0.02) * np.mean(found, axis=0)).all()


@pytest.mark.parametrize("held", [False, True])
def test_overlaps_under_a_stress_are_corrected_alike_anywhere(held):
    def overlaps(shift):
        pitch = 0.2 * (1 - 2e-3)
        pressed(*(rcr.disc((pitch * (k // 5 + 0.5) + shift, pitch * (k % 5 + 0.5)), 0.1,
                           material(0.3), fixed=held and k == 7) for k in range(25)),
                size=5 * pitch, stress=(100, 100), tolerance=1e-8, maxIterations=3000)
        found = []
        for _ in range(5):
            steps(20)
            found.append(-min(gaps()) / 0.2)
        return found

    expected = overlaps(0)
    assert expected[-1] < 1.1e-4 and solver().missedSteps == 0
    assert overlaps(300) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("columns, mass", [(5, 0.5), (10, 0.05)])
def test_a_light_cell_of_few_grains_converges(columns, mass):
    rng, m, pitch = np.random.default_rng(3), material(0.3), 0.2
    grains = [rcr.particle((pitch * (k % columns + 0.5), 0.5 * pitch * (k // columns + 0.5)),
                           0.0999, 0.5, rng.uniform(-0.02, 0.02), m) for k in range(columns**2)]
    pressed(*grains, size=columns * pitch, stress=(100, 100), mass=mass, tolerance=1e-4,
            dt=0.05 * math.sqrt(grains[0].state.mass / 100), solver="auto", maxIterations=2000)
    O.cell.setBox(columns * pitch, 0.5 * columns * pitch, 2)
    steps(150)
    assert solver().missedSteps < 5 and solver().deepestOverlap < 0.01


@pytest.mark.parametrize("tilt", [plane(0, 1e-3, 0, 0), plane(0, 0, 1e-3, 0),
                                  plane(0, 1e-3, 1e-3, 0)], ids=["xy", "yx", "both"])
def test_a_slight_tilt_keeps_the_inertia_of_a_cell(tilt):
    """M = Σ m L²/12 along each axis of a cell of 4 × 1 m without contacts."""
    stress, dt, n = 100, 1e-3, 20
    m = material(0)
    scene("rigid", *(rcr.disc((k + 0.5, 0.5), 0.1, material=m) for k in range(4)), dt=dt)
    O.cell.setBox(4, 1, 2)
    insert(3, rcr.CellStress(stress=(stress, stress)))
    O.cell.velGrad = tilt
    mass = sum(b.state.mass for b in O.bodies)
    steps(n)
    for k, length in enumerate((4, 1)):
        expected = -stress * 4 * n * dt / (mass * length**2 / 12)
        assert O.cell.velGrad[k, k] == pytest.approx(expected, rel=0.01)


def test_a_deforming_cell_far_from_the_origin_misses_no_steps():
    for far in (0, 1000):
        rng, pitch = np.random.default_rng(3), 0.204
        side = 4 * pitch
        scene("rigid", *(rcr.particle((pitch * (k % 4 + 0.5) + far * side, pitch * (k // 4 + 0.5)),
                                      rng.uniform(0.085, 0.1), 0.5, rng.uniform(0, 3),
                                      material(0.3)) for k in range(16)), size=side, dt=1e-3,
              tolerance=1e-8, overdamped=True)
        O.cell.velGrad = plane(-0.5, 0.5, 0.1, -0.5)
        steps(30)
        assert solver().missedSteps == 0


def test_clumps_under_a_stress_are_sheared():
    rng, pitch, n, m = np.random.default_rng(3), 0.2, 5, material(0.4)
    build(cell=n * pitch, gravity=(0, 0, 0), dt=5e-3, tolerance=1e-6, solver="auto")
    for k in range(n * n):
        x, y, angle = pitch * (k // n + 0.5), pitch * (k % n + 0.5), rng.uniform(0, 3)
        way = 0.035 * np.array([math.cos(angle), math.sin(angle)])
        if k % 2:
            rcr.clump([rcr.disc((x + s * way[0], y + s * way[1]), 0.06, m) for s in (-1, 1)])
        else:
            O.bodies.append(rcr.particle((x, y), rng.uniform(0.08, 0.095), 0.3, angle, m))
    insert(3, rcr.CellStress(stress=(500, 500)))
    O.cell.velGrad = plane(0, 0.8, 0, 0)
    for _ in range(600):
        O.step()
        if O.cell.hSize[0, 1] > 0.7 * O.cell.hSize[0, 0]:
            O.cell.flipCell()
    for b in O.bodies:
        for member in b.shape.members if b.isClump else ():
            assert (O.bodies[member].state.pos - b.state.pos).norm() == pytest.approx(0.035)
    assert solver().deepestOverlap < 1e-3 and solver().missedSteps < 20
    assert rcr.contact_network().between_particles.any()


def test_a_tilted_cell_and_its_turn_by_a_right_angle_have_one_inertia():
    """No lattice vector lies along an axis."""
    def rates(*cell):
        scene("rigid", rcr.disc((0.5, 0.5), 0.1, material()))
        O.cell.hSize = Matrix3(cell[0], cell[1], 0, cell[2], cell[3], 0, 0, 0, 2)
        pressed(stress=(10, 10))
        steps(1)
        return O.cell.velGrad[0, 0], O.cell.velGrad[1, 1]

    along, across = rates(2, 0.2, 0.1, 1)
    assert rates(1, -0.1, -0.2, 2) == pytest.approx((across, along), rel=1e-9)

"""The periodic cell: images across its boundary, the gradient of the velocity, stress, and saves (F8)."""

import math

import numpy as np
import pytest
import rcr
from scenes import engines, material, steps
from test_gate import ALL_IG2
from yade import O
from yade.minieigenHP import Matrix3
from yade.wrapper import ForceResetter, InsertionSortCollider, InteractionLoop, Ip2_FrictMat_FrictMat_FrictPhys, NewtonIntegrator


def scene(law, *bodies, size=2.0, gravity=(0, 0, 0), dt=1e-3, periodic=True, **options):
    O.reset()
    O.dt = dt
    O.periodic = periodic
    if periodic:
        O.cell.setBox(size, size, size)
    if law == "rigid":
        O.engines = engines(gravity=gravity, **options)
        O.engines[2].geomDispatcher.functors = [getattr(rcr, name)() for name in ALL_IG2]
    else:
        O.engines = [
            ForceResetter(),
            InsertionSortCollider([rcr.Bo1_Rcr_Aabb(), rcr.Bo1_Disc_Aabb()], verletDist=0.01),
            InteractionLoop([getattr(rcr, n)() for n in ALL_IG2], [Ip2_FrictMat_FrictMat_FrictPhys()], [rcr.Law2_RcrGeom_FrictPhys_CundallStrack()]),
            NewtonIntegrator(gravity=gravity, damping=0),
        ]
    return [O.bodies.append(b) for b in bodies]


def stiff():
    m = material()
    m.young, m.poisson = 1e7, 0.5
    return m


def pair(across, eta, m):
    """Two grains that overlap and slide and turn against each other, about x = 1 or about the boundary at x = 0 ≡ 2. The coordinates are
    binary fractions: shifted by a cell they are the same numbers."""
    R, overlap = 0.25, 2**-7
    left = (1 - R if not across else 2 - R, 1.0)
    right = (1 + R - overlap if not across else R - overlap, 1.0)
    return (
        rcr.particle(left, R, eta, angle=0.05, velocity=(0.3, 0.1), angular_velocity=2, material=m),
        rcr.particle(right, R, eta, angle=-0.02, velocity=(-0.2, -0.3), angular_velocity=-1, material=m),
    )


@pytest.mark.parametrize("law", ["rigid", "smooth"])
@pytest.mark.parametrize("eta", [0, 0.5])
def test_f8_pair_across_the_boundary_is_one_in_the_open(law, eta):
    def forces(across, periodic):
        dt = 4e-3 if law == "rigid" else 1e-5
        ids = scene(law, *pair(across, eta, stiff()), dt=dt, periodic=periodic)
        result = []
        for _ in range(10):
            O.step()
            result.append([*[x for i in ids for x in (*O.forces.f(i), *O.forces.t(i))], *[x for i in ids for x in (*O.bodies[i].state.vel, O.bodies[i].state.angVel[2])]])
        return np.array(result)

    inside, over = forces(False, False), forces(True, True)
    assert np.abs(inside[:, :12]).max() > 1  # they do push
    assert over == pytest.approx(inside, rel=1e-12, abs=1e-12 * np.abs(inside).max())
    assert forces(False, True) == pytest.approx(inside, rel=1e-12, abs=1e-12 * np.abs(inside).max())


@pytest.mark.parametrize("law", ["rigid", "smooth"])
def test_pair_in_a_sheared_cell_moves_with_the_image(law):
    """Two grains that follow a shear and a slow compression touch across the boundary in y: the image above is faster by γ̇ times their
    distance, friction holds it back and drags the other."""
    m = stiff()
    rate, size = 0.5, 2.0
    lower, upper = rcr.disc((1, 0.2), 0.2, material=m), rcr.disc((1, size - 0.2 + 1e-4), 0.2, material=m)
    ids = scene(law, lower, upper, size=size, dt=1e-5)
    O.cell.velGrad = Matrix3(0, rate, 0, 0, -0.1, 0, 0, 0, 0)
    steps(1 if law == "rigid" else 3)  # the rigid impact is over after one
    i = next(i for i in O.interactions if i.isReal)
    assert abs(i.cellDist[1]) == 1
    slip = rate * 0.4  # of the image above, which is 0.4 higher, against the body that it touches
    forces = np.array([O.forces.f(k) for k in ids])
    assert np.abs(forces[:, :2].sum(axis=0)).max() < 1e-9 * np.abs(forces).max()
    above = ids[0] if forces[0][1] > 0 else ids[1]  # pushed up: it is the upper one of the touching images
    assert above == ids[0]
    # the image of body 0 above the boundary is dragged ahead by γ̇ L: friction holds it back
    assert forces[0][0] * slip < 0 and forces[1][0] * slip > 0


def packing(eta, count=100, seed=2, radius=0.05, spread=1.35):
    rng = np.random.default_rng(seed)
    m = material(friction=0.0)
    n = int(math.sqrt(count))
    size = 2 * radius * spread * n
    places = [(2 * radius * spread * (i + 0.5), 2 * radius * spread * (j + 0.5)) for i in range(n) for j in range(n)]
    return size, m, [rcr.particle(at, radius * rng.uniform(0.7, 1), eta, angle=rng.uniform(0, 3), material=m) for at in places]


@pytest.mark.parametrize("eta", [0, 0.5])
def test_strain_driven_compaction_holds_its_grains_apart(eta):
    size, m, grains = packing(eta)
    scene("rigid", *grains, size=size, tolerance=1e-4, solver="auto", maxIterations=1000)
    area = sum(b.state.mass for b in O.bodies) / m.density
    fraction = lambda: area / (O.cell.hSize[0, 0] * O.cell.hSize[1, 1])
    O.cell.velGrad = Matrix3(-0.3, 0, 0, 0, -0.3, 0, 0, 0, 0)
    while fraction() < 0.76:
        steps(50)
    deepest = max(-i.geom.gap[k] for i in O.interactions if i.isReal for k in range(i.geom.points))
    assert O.engines[3].contactPoints > 50 and deepest < 0.01 * 0.1


def test_reload_goes_on_to_the_same_bits(tmp_path):
    size, m, grains = packing(0.5, count=49)
    scene("rigid", *grains, size=size, tolerance=1e-4, solver="auto", maxIterations=1000)
    O.cell.velGrad = Matrix3(-0.3, 0.2, 0, 0, -0.3, 0, 0, 0, 0)
    steps(700)
    O.save(str(tmp_path / "cell.yade"))
    state = lambda: [(*b.state.pos, *b.state.vel, *b.state.angVel) for b in O.bodies] + [tuple(O.cell.hSize.row(k)) for k in range(3)]
    steps(100)
    first = state()
    O.load(str(tmp_path / "cell.yade"))
    steps(100)
    assert state() == first


def test_walls_in_a_cell_are_refused():
    scene("rigid", rcr.particle((1, 1), 0.1, 0.5, material=material()))
    O.bodies.append(rcr.wall("y", 0, material=O.bodies[0].material))
    with pytest.raises(ValueError, match="#1 is a Wall in a periodic cell, which has no boundary"):
        O.step()


def test_cell_that_is_too_small_for_a_body_is_refused():
    """YADE's collider would end the process."""
    scene("rigid", rcr.particle((0.3, 0.3), 0.2, 0.5, material=material()), size=0.7)
    with pytest.raises(ValueError, match="the periodic cell is 0.7 wide at its narrowest, body #0 has the radius 0.2"):
        O.step()


def test_fast_body_in_a_cell_looks_less_far_ahead():
    m = material()
    fast = rcr.particle((0.3, 1), 0.1, 0.5, material=m, velocity=(200, 0))
    ids = scene("rigid", fast, rcr.disc((1.5, 1), 0.1, material=m), size=2.0, dt=5e-3)
    steps(20)
    assert O.bodies[ids[1]].state.vel[0] > 50  # it was hit, not passed


def test_boxes_of_fast_bodies_fit_a_sheared_cell():
    """Sheared by γ = 0.9, where boxes are wider by 40 %: YADE's collider would end the process."""
    m = material()
    fast = rcr.particle((0.3, 1), 0.1, 0.5, material=m, velocity=(200, 0))
    ids = scene("rigid", fast, rcr.disc((1.5, 1), 0.1, material=m), size=2.0, dt=5e-3)
    O.cell.hSize = Matrix3(2, 1.8, 0, 0, 2, 0, 0, 0, 2)
    steps(20)
    assert np.isfinite(O.bodies[ids[0]].state.vel[0])


def test_a_cell_that_shear_has_made_too_narrow_is_refused():
    m = material()
    scene("rigid", rcr.particle((0.3, 1), 0.3, 0.5, material=m), size=2.0)
    steps(1)
    O.cell.hSize = Matrix3(2, 8, 0, 0, 2, 0, 0, 0, 2)
    with pytest.raises(ValueError, match=r"sheared, so that radii count [89][\d.]* times: O\.cell\.flipCell"):
        steps(1)

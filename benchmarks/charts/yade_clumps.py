"""Biaxial test of YADE without this plugin: clumps of spheres under the stock law."""

import math

import numpy as np
from yade import utils
from yade.minieigenHP import Vector3
from yade import wrapper as w

import rcr
from rcr._yade.scene_arrays import angle
from rcr.network import BOTTOM, LEFT, RIGHT, TOP, Network
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL
from rcr.study.records import Springs

O = w.Omega()
STRESS = PROTOCOL.confining_stress  # [Pa]
DAMPING = 0.2  # local damping of the NewtonIntegrator [-]


class StockSprings(Springs):
    """Contacts of the stock law."""

    @property
    def contactPoints(self):
        return sum(i.isReal for i in O.interactions)


class Stock(Biaxial):
    """Biaxial test of clumps of spheres under the stock law; `stiffness` is k_n/σ₀ of spheres."""

    def __init__(self, test, stiffness):
        self.parameters, self.progress, self.rows = test.parameters, test.progress, []
        self.area, self.diameter, self.time_unit = test.area, test.diameter, test.time_unit
        self.solver = StockSprings()
        grains = [_grain(O.bodies[i]) for i in test.grains]
        walls = [O.bodies[i] for i in test.walls]
        edges = [wall.state.pos[wall.shape.axis] for wall in walls]
        mass = walls[2].state.mass
        O.reset()
        friction = math.atan(self.parameters["friction"])
        rough = O.materials.append(w.FrictMat(density=PROTOCOL.density, frictionAngle=friction))
        self.grains = [_clump(*grain, rough) for grain in grains]
        self._add_walls(edges, mass)
        kn, ks = stiffness * STRESS, PROTOCOL.shear_stiffness * stiffness * STRESS
        self._set_engines(kn, ks)
        fastest = max(max(kn / m, kn * a * a / inertia, ks * (a + r)**2 / inertia)
                      for _, _, a, r, m, inertia in grains)
        O.dt = PROTOCOL.smooth_time_step * 2 / math.sqrt(12 * fastest)  # as rcr.critical_time_step

    def _add_walls(self, edges, mass):
        plate = O.materials.append(w.FrictMat(density=PROTOCOL.density, frictionAngle=0))
        self.left, self.bottom, self.right, self.top = self.walls = O.bodies.append([
            rcr.mobile_wall("x", edges[0], mass, +1, plate),
            rcr.wall("y", edges[1], +1, material=plate),
            rcr.mobile_wall("x", edges[2], mass, -1, plate),
            rcr.wall("y", edges[3], -1, material=plate),
        ])

    def _set_engines(self, kn, ks):
        value = lambda k: w.MatchMaker(algo="val", val=k)
        O.engines = [
            w.ForceResetter(),
            w.InsertionSortCollider([w.Bo1_Sphere_Aabb(), w.Bo1_Wall_Aabb()],
                                    verletDist=0.1 * PROTOCOL.smallest_radius),
            w.InteractionLoop([w.Ig2_Sphere_Sphere_ScGeom(), w.Ig2_Wall_Sphere_ScGeom()],
                              [w.Ip2_FrictMat_FrictMat_FrictPhys(kn=value(kn), ks=value(ks))],
                              [w.Law2_ScGeom_FrictPhys_CundallStrack()]),
            *(rcr.WallStress(wall=wall, start=self.bottom, end=self.top, stress=stress)
              for wall, stress in ((self.left, STRESS), (self.right, -STRESS))),
            w.NewtonIntegrator(damping=DAMPING)]

    def network(self):
        """Contact network; all sphere contacts of two grains are one contact."""
        number = {i: k for k, i in enumerate(self.grains)}
        codes = dict(zip(self.walls, (LEFT, BOTTOM, RIGHT, TOP)))
        place = [np.array(O.bodies[i].state.pos)[:2] for i in self.grains]
        rows = []
        for (one, two), (along, across, point, count) in _pairs(codes).items():
            wall = two in codes
            point = point / count
            branch = (point if wall else place[number[two]]) - place[number[one]]
            rows.append((number[one], codes[two] if wall else number[two], 3 if wall else 0,
                         along / np.linalg.norm(along), branch, along + across, point,
                         min(count, 2)))
        columns = [np.array(column) for column in zip(*rows)]
        names = "body1 body2 type normal branch force position points".split()
        one, n = np.ones(len(self.grains)), len(self.grains)
        particles = dict(id=np.arange(n), position=np.array(place), angle=0 * one, R=one,
                         cap_radius=one, half_length=0 * one, mass=one, velocity=np.zeros((n, 3)))
        attributes = dict(time=O.time, strain=self.strain, dt=O.dt, volume=self.width * self.height)
        attributes |= {name: self.parameters[name] for name in ("eta", "friction", "seed")}
        return Network(particles, dict(zip(names, columns)), attributes)

    def overlaps(self):
        """Overlaps of the sphere contacts over the mean diameter [-]."""
        depths = [max(0, i.geom.penetrationDepth) for i in O.interactions if i.isReal]
        return np.array(depths) / self.diameter


def _grain(body):
    """(centre, angle, half length, cap radius, mass, moment of inertia) of an RCR."""
    state = body.state
    sizes = body.shape.halfLength, body.shape.capRadius
    return tuple(state.pos), angle(state.ori), *sizes, state.mass, state.inertia[2]


def _pairs(walls):
    """{ids: [normal, shear force on the second, sum of points, number]}; walls are second."""
    found = {}
    for i in O.interactions:
        if not (i.isReal and i.phys.normalForce.norm() > 0):
            continue
        bodies = O.bodies[i.id1], O.bodies[i.id2]
        pair, sign = [b.clumpId if b.isClumpMember else b.id for b in bodies], 1
        if pair[0] in walls or (pair[1] not in walls and pair[0] > pair[1]):
            pair, sign = pair[::-1], -1
        entry = found.setdefault(tuple(pair), [np.zeros(2), np.zeros(2), np.zeros(2), 0])
        entry[0] += sign * np.array(i.phys.normalForce)[:2]
        entry[1] += sign * np.array(i.phys.shearForce)[:2]
        entry[2] += np.array(i.geom.contactPoint)[:2]
        entry[3] += 1
    return found


def _clump(center, angle, a, r, mass, inertia, material):
    """Append a grain of spheres; returns the id of the body that moves."""
    count = 1 + math.ceil(4 * a / r)
    axis = np.array([math.cos(angle), math.sin(angle), 0])
    along = np.linspace(-a, a, count) if a > 0 else [0]
    spheres = [utils.sphere(tuple(np.array(center) + s * axis), r, material=material)
               for s in along]
    moving = O.bodies.append(spheres[0]) if a == 0 else O.bodies.appendClumped(spheres)[0]
    body = O.bodies[moving]
    body.state.mass, body.state.inertia = mass, Vector3(inertia, inertia, inertia)
    body.aspherical = False
    body.state.blockedDOFs = "zXY"
    return moving

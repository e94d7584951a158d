"""Random rows, columns, slots, stacks, carts, trees and packings as plain data, and their problems.

Grains are discs and rods whose axes all lie along `along` (0: x, 1: y), or upright bricks.
`problem` finds the contacts of a scene with NumPy and returns the arrays of `rcr._kernel.solve`. SI
units, per unit depth.
"""

import math

import numpy as np

from exact_solution import jacobian

R, DENSITY, DT, G = 0.01, 1000.0, 1e-3, 9.81
ALERT = 0.02 * R  # gap of the farthest contacts, further by the way of a step
PARALLEL = 1e-6 * R  # length of a common side that has two points
SOLVERS = {"auto": 12, "exact": 2, "nesterov": 2, "nlgs": 1, "sor": 1}  # with their frequencies


def grain(x, y, size=R, eta=0.0, mass=1.0, v=(0, 0)):
    """`mass` is a factor; a rod has the half length R η and the cap radius R (1 − η)."""
    return dict(x=float(x), y=float(y), R=float(size), eta=eta, mass=mass, v=tuple(map(float, v)))


def brick(x, y, half):
    """A rectangle with these half widths."""
    return dict(grain(x, y, math.hypot(*half)), half=tuple(map(float, half)))


def wall(axis, at, sense, friction=0.0, v=0.0, load=0.0, mass=0.0):
    """A wall; with a mass [kg] it moves along its normal under a `load` [N]."""
    return dict(axis=axis, at=float(at), sense=sense, friction=friction, v=float(v),
                load=float(load), mass=mass)  # fmt: skip


# ---- families: (rng, count, pick) to a scene


def row(rng, count, pick):
    """Discs or upright rods side by side; a wall strikes them, a lid presses them, or neither."""
    eta = pick(0.0, 0.0, 0.5)
    width = R * (1 - eta)
    grains = [grain(width * (2 * k + 1), R, R, eta) for k in range(count)]
    left = [wall(0, 0, 1, v=pick(0, 0, 0.01, 0.1, 1)) for _ in range(pick(0, 1, 1))]
    load = pick(0.1, 10, 1000)
    right = pick([], [], [wall(0, 2 * width * count, -1)],
                 [wall(0, 2 * width * count, -1, load=-load, mass=10 ** rng.uniform(-3, 3))])
    if any(w["v"] for w in left) and any(not w["mass"] for w in right):
        right = []
    floor = [wall(1, 0, 1)] if pick(0, 1) else []
    return dict(grains=grains, walls=[*left, *right, *floor], along=1, friction=pick(0.0, 0.5),
                gravity=pick(0, G) if floor else 0.0)


def column(rng, count, pick):
    """Discs one above another on a floor, perhaps between walls that touch them."""
    grains = [grain(0, R * (2 * k + 1)) for k in range(count)]
    sides = pick([], [], [wall(0, -R, 1)], [wall(0, -R, 1), wall(0, R, -1)])
    rough = 0.5 * pick(0, 1)
    return dict(grains=grains, walls=[wall(1, 0, 1, rough), *sides], along=0,
                friction=rough, gravity=G)


def slot(rng, count, pick):
    """Discs in zigzag between two walls."""
    shift = R * pick(0, rng.uniform(0, 0.9))
    rise = math.sqrt(4 * R**2 - 4 * shift**2)
    grains = [grain(shift * (-1) ** k, R + rise * k) for k in range(count)]
    walls = [wall(1, 0, 1), wall(0, -R - shift, 1), wall(0, R + shift, -1)]
    return dict(grains=grains, walls=walls, along=0, friction=0.0, gravity=G)


def stack(rng, count, pick):
    """Flat rods one upon another, perhaps shifted."""
    eta, shift = pick(0.3, 0.5, 0.8), pick(0, 0, 0.2)
    height = 2 * R * (1 - eta)
    grains = [grain(shift * R * eta * rng.uniform(-1, 1), height * (k + 0.5), R, eta)
              for k in range(count)]
    rough = pick(0.0, 0.5, 0.5)
    beside = [wall(0, min(g["x"] for g in grains) - 1.005 * R, 1, rough)] if pick(0, 1) else []
    return dict(grains=grains, walls=[wall(1, 0, 1, rough), *beside], along=0, friction=rough,
                gravity=G)


def cart(rng, count, pick):
    """A stack of rods on a heavy one that coasts on a smooth floor."""
    count = min(count, 60)
    grains = [grain(0, R, 10 * R, 0.9, 10 ** rng.uniform(0, 6)),
              *(grain(0, 2 * R + R * (k + 0.5), R, 0.5) for k in range(count))]
    return dict(grains=grains, walls=[wall(1, 0, 1)], along=0, friction=0.5, gravity=G)


def tree(rng, count, pick):
    """Discs without loops: each touches one earlier disc. A wall strikes the tree from below."""
    centers = [complex(0, R)]
    while len(centers) < count:
        place = np.array(centers)
        at = place[max(0, len(place) - 8):][rng.integers(min(8, len(place)))]
        at += 2 * R * np.exp(1j * rng.uniform(0, math.pi))
        if at.imag > 1.2 * R and np.sort(abs(place - at))[1:2].min(initial=9) > 2.1 * R:
            centers.append(at)
    grains = [grain(z.real, z.imag) for z in centers]
    rough = pick(0.0, 0.3)
    return dict(grains=grains, walls=[wall(1, 0, 1, rough, pick(0, 0.01, 1))], along=0,
                friction=rough, gravity=pick(0.0, G))


def packing(rng, count, pick):
    """Discs on a hexagonal lattice in a box, with vacancies and gaps, perhaps under a lid."""
    count, gap = min(count, 150), pick(0, 0, 1e-6, 1e-4)
    width = int(rng.integers(2, 3 + math.isqrt(count)))
    grains = []
    for k in range(count):
        level, place = divmod(k, width)
        if rng.random() < 0.9 or level == 0:
            at = np.array([R * (2 * place + 1 + level % 2), R * (1 + math.sqrt(3) * level)])
            grains.append(grain(*at * (1 + gap), R * (1 - gap * rng.random())))
    rough = pick(0.0, 0.0, 0.3)
    box = [wall(1, 0, 1, rough), wall(0, 0, 1, rough), wall(0, R * (2 * width + 1), -1, rough)]
    top = max(g["y"] + g["R"] for g in grains)
    load, mass = pick(0.1, 10, 1000), 10 ** rng.uniform(-2, 3)
    lid = pick([], [wall(1, top, -1, rough, load=-load, mass=mass)])
    return dict(grains=grains, walls=[*box, *lid], along=0, friction=rough, gravity=pick(0.0, G, G))


def bricks(rng, count, pick):
    """Courses of bricks in running bond or above each other, perhaps under a lid."""
    columns, half = int(rng.integers(1, 8)), (R * pick(0.5, 1, 2), R * pick(0.5, 1))
    gap, bond = pick(0, 0, 1e-4) * R, pick(0, 1)
    courses = range(min(1 + count // columns, 12))
    grains = [brick(half[0] * (2 * k + bond * (course % 2)) * (1 + gap), half[1] * (2 * course + 1),
                    half) for course in courses for k in range(columns)]
    rough = pick(0.0, 0.5, 0.5)
    load, mass = pick(0.1, 10, 1000), 10 ** rng.uniform(-2, 3)
    lid = pick([], [wall(1, 2 * half[1] * len(courses), -1, rough, load=-load, mass=mass)])
    return dict(grains=grains, walls=[wall(1, 0, 1, rough), *lid], along=0, friction=rough,
                gravity=pick(0.0, G, G))


def _fast_pair(grains, walls, speed):
    """Two discs of which one strikes the other, far from all others; none where walls enclose all.
    """
    place = np.array([(g["x"], g["y"]) for g in grains])
    for x in place[:, 0].min() - 50 * R, place[:, 0].max() + 50 * R:
        y = place[:, 1].max() + 50 * R
        if all(w["sense"] * ((x, y)[w["axis"]] - w["at"]) > 10 * R for w in walls):
            return [grain(x, y, v=(speed, 0)), grain(x + 2.0001 * R, y)]
    return []


FAMILIES = row, column, slot, stack, cart, tree, packing


def draw(seed):
    """A random scene with its solver."""
    rng = np.random.default_rng(seed)
    pick = lambda *values: values[rng.integers(len(values))]
    family = bricks if seed % 8 == 7 else FAMILIES[rng.integers(len(FAMILIES))]
    count = int(round(2 * 150 ** rng.random() ** pick(0.5, 1, 2)))
    scene = family(rng, count, pick)
    grains, walls = scene["grains"], scene["walls"]
    rho = pick(0, 0, 1, 2, 3)
    for g in grains:
        g["mass"] *= 10 ** (rho * rng.uniform(-1, 1)) if rho else 1
    if pick(0, 0, 1):
        heavy = pick(0, len(grains) - 1, int(rng.integers(len(grains))))
        grains[heavy]["mass"] *= 10 ** rng.uniform(0, 6)
    thrown = pick(0, 0, 0, 0.01, 1)  # speed of impacts [m/s]
    for g in grains:
        if thrown and rng.random() < pick(0.05, 1):
            g["v"] = tuple(thrown * rng.uniform(-1, 1, 2))
    # a floor with friction cannot move along itself
    rough = any(w["friction"] for w in walls)
    boost = pick(0, 0, 0.1, 1, 10) * np.array(pick((1, 0), (0, 1)) if not rough else (0, 1))
    if pick(0, 0, 0, 1):  # idle: beyond all grains, at rest with them
        walls.append(wall(0, max(g["x"] + g["R"] for g in grains) + pick(1e-5, 0.005) * R, -1))
    if pick(0, 0, 0, 1) and family is not bricks:
        grains += _fast_pair(grains, walls, pick(1, 10))
    for g in grains:
        g["v"] = tuple(float(v) for v in np.array(g["v"]) + boost)
    for w in walls:
        w["v"] += float(boost[w["axis"]])
    order = rng.permutation(len(grains))
    names = [name for name, times in SOLVERS.items() for _ in range(times)]
    return dict(scene, grains=[grains[k] for k in order] if pick(0, 1) else grains,
                restitution=pick(0.0, 0.0, 0.3, 1.0), warm=pick(True, False),
                solver=pick(*names), family=family.__name__, seed=seed)


# ---- the problem of a scene


def mass_and_inertia(g):
    """Of a brick, or a rod with round caps."""
    if "half" in g:
        a, b = g["half"]
        mass = g["mass"] * DENSITY * 4 * a * b
        return mass, mass * (a**2 + b**2) / 3
    a, c = g["R"] * g["eta"], g["R"] * (1 - g["eta"])
    square, caps = 4 * a * c, math.pi * c**2
    reach = a + 4 * c / (3 * math.pi)  # centroid of a cap
    inertia = (square * (4 * a**2 + 4 * c**2) / 12
               + caps * (c**2 / 2 - (4 * c / (3 * math.pi)) ** 2 + reach**2))
    return g["mass"] * DENSITY * (square + caps), g["mass"] * DENSITY * inertia


def problem(scene):
    """Arrays of the first step: grains first, then walls."""
    grains, walls, along = scene["grains"], scene["walls"], scene["along"]
    masses = np.array([mass_and_inertia(g) for g in grains])
    inverse = np.zeros((len(grains) + len(walls), 3))
    inverse[:len(grains)] = 1 / masses[:, [0, 0, 1]]
    before = np.zeros(inverse.shape)
    before[:len(grains), :2] = [g["v"] for g in grains]
    force = np.zeros(inverse.shape)
    force[:len(grains), 1] = -scene["gravity"]
    for k, w in enumerate(walls, len(grains)):
        before[k, w["axis"]] = w["v"]
        if w["mass"]:
            inverse[k, w["axis"]] = 1 / w["mass"]
            force[k, w["axis"]] = w["load"] / w["mass"] - scene["gravity"] * (w["axis"] == 1)
    if grains and "half" in grains[0]:
        found = [*_brick_points(grains, scene), *_bricks_on_walls(grains, walls, scene)]
    else:
        found = [*_grain_points(grains, along, scene), *_wall_points(grains, walls, along, scene)]
    points = sorted(found, key=lambda point: point[:2])
    table = np.array(points, float).reshape(-1, 10)
    found = dict(inverse_mass=inverse, free_velocity=before + DT * force,
                 bodies=table[:, :2].astype(np.int32), normal=table[:, 2:4], arm1=table[:, 4:6],
                 arm2=table[:, 6:8], bias=np.maximum(table[:, 8], 0) / DT, friction=table[:, 9],
                 impulse=np.zeros((len(table), 2)))
    found = {name: np.ascontiguousarray(value) for name, value in found.items()}
    return found, dict(before=before, acceleration=force, gap=table[:, 8].copy())


def _half(g):
    return g["R"] * g["eta"]


def _cap(g):
    return g["R"] * (1 - g["eta"])


def _reach(scene, relative):
    return ALERT + DT * relative


def _grain_points(grains, along, scene):
    """Rows (body 1, body 2, normal, arm 1, arm 2, gap, friction)."""
    at = np.array([(g["x"], g["y"]) for g in grains])
    v = np.array([g["v"] for g in grains])
    half, cap = (np.array([part(g) for g in grains]) for part in (_half, _cap))
    far = np.array([g["R"] for g in grains])
    for i in range(len(grains)):
        d = at[i + 1:] - at[i]
        speed = np.hypot(*(v[i + 1:] - v[i]).T)
        near = np.hypot(*d.T) < far[i] + far[i + 1:] + _reach(scene, speed)
        for j in i + 1 + np.flatnonzero(near):
            gap = at[j] - at[i]
            low = max(-half[i], gap[along] - half[j])
            high = min(half[i], gap[along] + half[j])
            ends = (low, high) if high - low > PARALLEL else (0.5 * (low + high),)
            for end in ends:
                one, two = np.zeros(2), np.zeros(2)  # points of the cores, about both centres
                one[along] = np.clip(end, -half[i], half[i])
                two[along] = np.clip(end - gap[along], -half[j], half[j])
                n = gap + two - one
                length = np.hypot(*n)
                n = n / length
                if length - cap[i] - cap[j] < _reach(scene, np.hypot(*(v[j] - v[i]))):
                    yield (i, j, *n, *one + cap[i] * n, *two - cap[j] * n,
                           length - cap[i] - cap[j], scene["friction"])


def _wall_points(grains, walls, along, scene):
    for k, w in enumerate(walls, len(grains)):
        axis, n = w["axis"], np.zeros(2)
        n[axis] = -w["sense"]  # from the grain to the wall
        for i, g in enumerate(grains):
            ends = (-_half(g), _half(g)) if g["eta"] and axis != along else (
                (-w["sense"] * _half(g),) if axis == along else (0.0,))
            for end in ends:
                core = np.zeros(2)
                core[along] = end
                gap = w["sense"] * ((g["x"], g["y"])[axis] + core[axis] - w["at"]) - _cap(g)
                if gap < _reach(scene, abs(g["v"][axis] - w["v"])):
                    arm = core + _cap(g) * n
                    middle = np.array((g["x"], g["y"]))
                    foot = middle + arm - np.where(np.arange(2) == axis, w["at"], 0)
                    yield (i, k, *n, *arm, *foot, gap, min(w["friction"], scene["friction"]))


def _brick_points(grains, scene):
    """The ends of the common side of two bricks, or the closest corners."""
    for i, one in enumerate(grains):
        for j in range(i + 1, len(grains)):
            two = grains[j]
            d = np.array((two["x"] - one["x"], two["y"] - one["y"]))
            halves = np.array((one["half"], two["half"]))
            gaps, sign = abs(d) - halves.sum(axis=0), np.where(d < 0, -1, 1)
            reach = _reach(scene, math.dist(one["v"], two["v"]))
            if gaps.max() >= reach:
                continue
            normal, axis = np.zeros(2), int(gaps.argmax())
            normal[axis] = sign[axis]
            other = 1 - axis
            low = max(-halves[0, other], d[other] - halves[1, other])
            high = min(halves[0, other], d[other] + halves[1, other])
            if high - low > PARALLEL:
                ends, gap = (low, high), gaps[axis]
            elif gaps.min() > 0:  # corners
                gap = np.hypot(*gaps)
                normal = gaps * sign / gap
                ends = (sign[other] * halves[0, other],)
            else:
                continue
            for end in ends:
                arm = np.where(np.arange(2) == axis, sign * halves[0], end)
                if gap < reach:
                    yield (i, j, *normal, *arm, *(arm + gap * normal - d), gap, scene["friction"])


def _bricks_on_walls(grains, walls, scene):
    for k, w in enumerate(walls, len(grains)):
        axis, n = w["axis"], np.zeros(2)
        n[axis] = -w["sense"]  # from the brick to the wall
        for i, g in enumerate(grains):
            gap = w["sense"] * ((g["x"], g["y"])[axis] - w["at"]) - g["half"][axis]
            if gap >= _reach(scene, abs(g["v"][axis] - w["v"])):
                continue
            for end in (-1, 1):
                arm = np.where(np.arange(2) == axis, n, end) * g["half"]
                foot = np.array((g["x"], g["y"])) + arm
                foot = foot - np.where(np.arange(2) == axis, w["at"], 0)
                yield (i, k, *n, *arm, *foot, gap, min(w["friction"], scene["friction"]))


def impact(found, state, restitution):
    """Set the biases of restitution: u_n ≥ −e u_n before, for closed points that approach."""
    u = (jacobian(found) @ state["before"].ravel())[::2]
    closing = (state["gap"] <= 1e-9 * R) & (u < -10 * G * DT)
    found["bias"] = np.where(closing, restitution * u, np.maximum(state["gap"], 0) / DT)


def advance(found, state, velocity, relative, impulse):
    """The problem of the next step with fixed normals and arms, from the impulses of this one."""
    gap = state["gap"] + DT * relative[:, 0]
    state = dict(state, before=velocity, gap=gap)
    return dict(found, free_velocity=velocity + DT * state["acceleration"], impulse=impulse), state

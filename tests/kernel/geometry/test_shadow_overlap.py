"""Shadow overlap against independent references.

The cores a₁e₁ and a₂e₂ overlap if the centre difference d lies in their Minkowski difference, the
parallelogram that they span. The gap of two stadiums is the signed distance of d to it, minus both
cap radii.
"""

import numpy as np
import pytest
from kernel.contact_problems import problem_of
from rcr import _kernel

ROUNDING = 1e-13  # some operations on lengths of order 1
PAIRS = 100_000
ALERT = 0.05
TILTS = [0, 1e-15, 1e-9, 1e-6, 1e-3, 1e-2]
CAP_CAP, CAP_SIDE, SIDE_SIDE, OBSTACLE = range(4)


# ---- poses

def random_pairs(seed, n=PAIRS):
    """Stadiums (n, 2) and poses (n, 3) of n pairs of seven kinds, most of them near contact."""
    rng = np.random.default_rng(seed)
    stadium1, stadium2 = rng.uniform(0.02, 1, (n, 2)), rng.uniform(0.02, 1, (n, 2))
    angle = rng.uniform(-np.pi, np.pi, (2, n))
    kind = rng.integers(0, 7, n)
    # parallel and nearly parallel sides that face each other
    tilted = angle[0] + rng.choice([0, np.pi], n) + rng.choice(TILTS, n)
    angle[1] = np.where(kind == 1, tilted, angle[1])
    stadium2[kind == 2, 0] = 0  # disc on a side or an end
    stadium1[kind == 3, 0] = 0
    stadium1[kind == 4, 0] = stadium2[kind == 4, 0] = 0
    angle[1] = np.where(kind == 5, angle[0] + rng.choice([0, np.pi], n), angle[1])  # end to end

    axis = np.stack([np.cos(angle[0]), np.sin(angle[0])], axis=1)
    normal = np.stack([-axis[:, 1], axis[:, 0]], axis=1)
    radii, lengths = stadium1[:, 1] + stadium2[:, 1], stadium1[:, 0] + stadium2[:, 0]
    along = rng.uniform(-1.1, 1.1, n) * lengths
    across = rng.choice([-1, 1], n) * (radii + rng.uniform(-0.5, 1.2, n) * ALERT)
    d = along[:, None] * axis + across[:, None] * normal
    end_to_end = (lengths + radii + rng.uniform(-0.5, 1.2, n) * ALERT)[:, None] * axis
    d[kind == 5] = end_to_end[kind == 5]
    d[kind == 6] = (rng.uniform(0, 1, (n, 1)) * d)[kind == 6]  # crossing cores, deep overlaps
    center1 = rng.uniform(-1, 1, (n, 2))
    pose1 = np.column_stack([center1, angle[0]])
    return stadium1, pose1, stadium2, np.column_stack([center1 + d, angle[1]])


def axes(pose):
    return np.stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])], axis=1)


def assert_none(fails, pairs, what, function="overlap_stadiums"):
    """Fail on the first True of `fails`, with a call that repeats this pair."""
    bad = np.flatnonzero(fails)
    arrays = ", ".join(repr(np.asarray(array)[bad[:1]].tolist()) for array in pairs)
    assert not len(bad), (f"{what}: {len(bad)} of {len(fails)}, first #{bad[0]}; "
                          f"replay: _kernel.{function}({arrays}, {ALERT})")


# ---- references

def dot(a, b):
    return np.einsum("...i,...i", a, b)


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def distance_to_segment(point, end1, end2):
    edge = end2 - end1
    length2 = dot(edge, edge)
    t = np.clip(dot(point - end1, edge) / np.where(length2 > 0, length2, 1), 0, 1)
    return np.linalg.norm(point - end1 - t[:, None] * edge, axis=1)


def core_distance(stadium1, pose1, stadium2, pose2):
    """Signed distance of d to the parallelogram of the cores; negative for crossing cores."""
    d = pose2[:, :2] - pose1[:, :2]
    e1, e2 = axes(pose1), axes(pose2)
    u, v = stadium1[:, :1] * e1, stadium2[:, :1] * e2
    corners = [u + v, u - v, -u - v, -u + v]
    edges = [distance_to_segment(d, corners[k], corners[k - 1]) for k in range(4)]
    distance = np.min(edges, axis=0)
    a1, a2 = stadium1[:, 0], stadium2[:, 0]
    sine = np.abs(cross(e1, e2))  # d = s e₁ + t e₂ with |s| < a₁ and |t| < a₂
    inside = (np.abs(cross(d, e2)) < a1 * sine) & (np.abs(cross(e1, d)) < a2 * sine)
    # for parallel cores, the sines are rounding
    inside &= np.abs(dot(d, e1)) < a1 + a2 * np.abs(dot(e1, e2))
    return np.where(inside, -distance, distance)


def reference_points(stadium1, pose1, stadium2, pose2, alert):
    """Number of points by the rule of the second point, and the least margins of its decisions.
    Candidates are ends of one core that face the interior of the other, on the side of the closest
    point and within the alert distance. The second point is the farthest candidate.
    """
    radii = stadium1[:, 1] + stadium2[:, 1]
    found = []  # position, normal, gap, inside, margin of each end
    bodies = (stadium1, pose1), (stadium2, pose2)
    for (sa, pa), (sb, pb), flip in ((*bodies, 1), (*bodies[::-1], -1)):
        ea, eb = axes(pa), axes(pb)
        for side in (-1, 1):
            end = pb[:, :2] + side * sb[:, :1] * eb
            s = dot(end - pa[:, :2], ea)
            foot = pa[:, :2] + np.clip(s, -sa[:, 0], sa[:, 0])[:, None] * ea
            delta = end - foot
            distance = np.linalg.norm(delta, axis=1)
            with np.errstate(invalid="ignore", divide="ignore"):
                normal = flip * delta / distance[:, None]
            middle = 0.5 * (foot + end + flip * normal * (sa[:, 1:] - sb[:, 1:]))
            inside = (np.abs(s) <= sa[:, 0]) & (sa[:, 0] > 0)
            margin = np.where(sa[:, 0] > 0, np.abs(np.abs(s) - sa[:, 0]), np.inf)
            found.append((middle, normal, distance - radii, inside, margin))
    position, normal, gap, inside, margin = (np.array(x) for x in zip(*found))
    rows = np.arange(len(radii))
    first = np.argmin(gap, axis=0)
    facing = dot(normal, normal[first, rows])
    far = np.linalg.norm(position - position[first, rows], axis=2)
    second = inside & (gap <= alert) & (facing > 0) & (far > 1e-9 * radii)
    count = np.where(gap.min(axis=0) <= alert, 1 + second.any(axis=0), 0)
    margins = np.minimum(margin, np.abs(gap - alert)).min(axis=0)
    margins = np.minimum(margins, np.abs(facing).min(axis=0))  # same or opposite side
    apart = np.where(far > 0, np.abs(far - 1e-9 * radii), 1)
    margins = np.minimum(margins, apart.min(axis=0))
    return count, np.nan_to_num(margins)


# ---- two stadiums

@pytest.fixture(scope="module", params=range(4), ids="seed {}".format)
def pairs(request):
    return random_pairs(request.param)


def test_gap_is_the_signed_distance_of_the_cores(pairs):
    gap = core_distance(*pairs) - pairs[0][:, 1] - pairs[2][:, 1]
    assert 0.3 * PAIRS < (gap <= ALERT).sum() < 0.95 * PAIRS  # both results occur
    assert (gap < -0.2).sum() > 0.01 * PAIRS
    for alert in (ALERT, np.inf):
        found = _kernel.overlap_stadiums(*pairs, alert)
        seen = found["count"] > 0
        assert_none(seen != (gap <= alert), pairs, f"detection at the alert distance {alert}")
        deepest = np.nanmin(np.where(seen[:, None], found["gap"], np.inf), axis=1)
        with np.errstate(invalid="ignore"):
            assert_none(seen & ~(np.abs(deepest - gap) < ROUNDING), pairs, "gap of deepest points")


def test_points_lie_midway_between_the_surfaces(pairs):
    """position ± (gap/2) n lie R'₁ and R'₂ from the cores, unless these cross."""
    stadium1, pose1, stadium2, pose2 = pairs
    found = _kernel.overlap_stadiums(*pairs, ALERT)
    crossed = core_distance(*pairs) < 1e-9
    for k in range(2):
        used = found["count"] > k
        x, n, half = found["position"][:, k], found["normal"][:, k], 0.5 * found["gap"][:, k, None]
        with np.errstate(invalid="ignore"):
            unit = np.abs(np.linalg.norm(n, axis=1) - 1) <= ROUNDING
            assert_none(used & ~unit, pairs, "normal of unit length")
            for core, stadium, pose in (
                (x - (half + stadium1[:, 1:]) * n, stadium1, pose1),
                (x + (half + stadium2[:, 1:]) * n, stadium2, pose2),
            ):
                half_core = stadium[:, :1] * axes(pose)
                center = pose[:, :2]
                off = distance_to_segment(core, center - half_core, center + half_core)
                assert_none(used & ~crossed & ~(off <= ROUNDING), pairs, f"point {k} on surfaces")
    assert crossed.sum() > 100


def test_second_point_follows_its_rule(pairs):
    found = _kernel.overlap_stadiums(*pairs, ALERT)
    count, margin = reference_points(*pairs, ALERT)
    # closer to a threshold, rounding decides
    clear = (margin > 1e-10) & (core_distance(*pairs) >= 1e-9)
    assert clear.sum() > 0.6 * PAIRS and (count[clear] == 2).sum() > 0.05 * PAIRS
    assert_none(clear & (found["count"] != count), pairs, "number of points")
    assert_none((found["type"] == SIDE_SIDE) != (found["count"] == 2), pairs, "type")
    along = dot(found["position"][:, 1] - found["position"][:, 0], axes(pairs[1]))
    assert_none((found["count"] == 2) & ~(along >= 0), pairs, "order of points")


def one(stadium1, stadium2, pose2):
    found = _kernel.overlap_stadiums([stadium1], [(0, 0, 0)], [stadium2], [pose2], ALERT)
    return {name: values[0] for name, values in found.items()}


@pytest.mark.parametrize("stadium1, stadium2, pose2, kind, gaps", [
    pytest.param((0, 0.5), (0, 0.25), (0.77, 0, 1), CAP_CAP, [0.02], id="two discs"),
    pytest.param((0, 0.5), (0, 0.25), (0.7, 0, 1), CAP_CAP, [-0.05], id="two overlapping discs"),
    pytest.param((1, 0.5), (0, 0.25), (0.3, 0.75, 0), CAP_SIDE, [0], id="disc on a side"),
    pytest.param((1, 0.5), (0, 0.25), (1.75, 0, 0), CAP_CAP, [0], id="disc on an end"),
    pytest.param((1, 0.5), (1, 0.25), (2.8, 0, 0), CAP_CAP, [0.05], id="end to end"),
    pytest.param((1, 0.5), (1, 0.5), (0.5, 0.99, 0), SIDE_SIDE, [-0.01] * 2, id="side on side"),
    pytest.param((1, 0.5), (1, 0.5), (0, 0, 0), SIDE_SIDE, [-1, -1], id="equal poses"),
    pytest.param((1, 0.5), (1, 0.25), (0, 1.75, np.pi / 2), CAP_SIDE, [0], id="upright on a side"),
    pytest.param((1, 0.5), (1, 0.5), (0.2, 0.4, np.pi / 2), CAP_SIDE, [-1.6], id="crossing by 0.6"),
    pytest.param((0, 0.5), (0, 0.25), (0.81, 0, 0), CAP_CAP, [], id="beyond the alert distance"),
])
def test_one_case_per_branch(stadium1, stadium2, pose2, kind, gaps):
    """Body 1 stands at the origin, along x."""
    found = one(stadium1, stadium2, pose2)
    assert found["count"] == len(gaps)
    assert found["gap"][: len(gaps)] == pytest.approx(gaps, abs=ROUNDING)
    assert not gaps or found["type"] == kind


def test_eccentric_side_contact_spans_the_shadow():
    """Equal stadiums shifted by s along their sides face each other from s − a to a."""
    found = one((1, 0.5), (1, 0.5), (0.5, 1, 0))
    assert found["position"] == pytest.approx(np.array([[-0.5, 0.5], [1, 0.5]]), abs=ROUNDING)
    assert found["normal"] == pytest.approx(np.array([[0, 1], [0, 1]]), abs=ROUNDING)


# ---- invariance

def test_flush_equal_bodies_have_two_points():
    """At any position and angle, the ends face each other up to rounding."""
    rng = np.random.default_rng(7)
    n = 10_000
    stadium = np.tile([0.5, 0.5], (n, 1))
    pose = np.column_stack([rng.uniform(-10, 10, (n, 2)), rng.choice([0, rng.uniform(-3, 3)], n)])
    normal = np.column_stack([-np.sin(pose[:, 2]), np.cos(pose[:, 2])])
    above = pose + np.column_stack([normal, np.zeros(n)])
    pairs = stadium, pose, stadium, above
    assert_none(_kernel.overlap_stadiums(*pairs, ALERT)["count"] != 2, pairs, "one point")


def test_collinear_bodies_have_consistent_normals():
    """Rounding selects the side of overlapping collinear cores; it is the same for both points."""
    rng = np.random.default_rng(3)
    n = 1000
    stadium = lambda: np.column_stack([rng.uniform(0.2, 1, n), rng.uniform(0.05, 1, n)])
    stadium1, stadium2 = stadium(), stadium()
    pose1 = rng.uniform(-1, 1, (n, 3)) * (1, 1, np.pi)
    along = rng.uniform(-1, 1, n) * (stadium1[:, 0] + stadium2[:, 0])
    pose2 = pose1 + np.column_stack([along[:, None] * axes(pose1), rng.choice([0, np.pi], n)])
    found = _kernel.overlap_stadiums(stadium1, pose1, stadium2, pose2, ALERT)
    both = found["count"] == 2
    cosine = dot(found["normal"][:, 0], found["normal"][:, 1])
    assert (found["count"] > 0).all() and not (both & ~(cosine > 0)).any()


def assert_equal(found, expected, pairs, clear, tolerance):
    """Fail if a quantity of the contacts of clear pairs differs; unused points are NaN."""
    for name in ("count", "type", "position", "normal", "gap"):
        same = np.isclose(found[name], expected[name], rtol=0, atol=tolerance, equal_nan=True)
        assert_none(clear & ~same.reshape(len(clear), -1).all(axis=1), pairs, name)


def clear_pairs(seed):
    """Pairs whose decisions do not depend on rounding, so a motion must not change them."""
    pairs = random_pairs(seed)
    count, margin = reference_points(*pairs, ALERT)
    # crossing cores have several translations of similar length
    clear = (margin > 1e-9) & (core_distance(*pairs) > 1e-6)
    # rounding selects the closest point of parallel sides if the other is out of reach
    clear &= (count != 1) | (np.abs(cross(axes(pairs[1]), axes(pairs[3]))) >= 1e-5)
    assert clear.sum() > 0.4 * PAIRS
    return pairs, clear


@pytest.mark.parametrize("angle, shift, sign", [
    (0, (3, -2), 1), (1, (0, 0), 1), (np.pi / 2, (1, 1), 1), (0.4, (0, 0), -1),
])
def test_manifold_moves_with_the_pair(angle, shift, sign):
    """Pairs are mirrored at the x axis (sign −1), rotated about the origin, and shifted."""
    pairs, clear = clear_pairs(seed=7)
    expected = _kernel.overlap_stadiums(*pairs, ALERT)
    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([[c, -s], [s, c]]) @ np.diag([1, sign])
    pose = lambda p: np.column_stack([p[:, :2] @ matrix.T + shift, sign * p[:, 2] + angle])
    pairs = pairs[0], pose(pairs[1]), pairs[2], pose(pairs[3])
    expected["position"] = expected["position"] @ matrix.T + shift
    expected["normal"] = expected["normal"] @ matrix.T
    # normals of cap-cap contacts lose digits for close cores; their distance is at least 1e-6 here
    assert_equal(_kernel.overlap_stadiums(*pairs, ALERT), expected, pairs, clear, 1e-8)


def test_swapping_the_bodies_flips_the_normals():
    pairs, clear = clear_pairs(seed=8)
    found = _kernel.overlap_stadiums(*pairs, ALERT)
    expected = _kernel.overlap_stadiums(*pairs[2:], *pairs[:2], ALERT)
    expected["normal"] = -expected["normal"]
    along = dot(expected["position"][:, 1] - expected["position"][:, 0], axes(pairs[1]))
    # points are ordered along the axis of the other body
    back = (expected["count"] == 2) & (along < 0)
    for name in ("position", "normal", "gap"):
        expected[name][back] = expected[name][back][:, ::-1]
    assert_equal(found, expected, pairs, clear, ROUNDING / 1e-6)


@pytest.mark.parametrize("array, column", [(a, c) for a in range(4) for c in range(2 + a % 2)])
def test_nan_is_no_contact(array, column):
    values = (1.0, 0.5), (0.0, 0, 0), (1.0, 0.5), (0.1, 0.9, 0.01)
    arrays = [np.array([row]) for row in values]
    assert _kernel.overlap_stadiums(*arrays, ALERT)["count"] == 2
    arrays[array][0, column] = np.nan
    assert _kernel.overlap_stadiums(*arrays, ALERT)["count"] == 0


# ---- wall and box

def test_wall_contacts_each_cap():
    """The gap of an end is (end − origin)·n − R'; a disc has one end."""
    rng = np.random.default_rng(3)
    n = 20_000
    stadium = rng.uniform(0.05, 1, (n, 2)) * np.stack([rng.integers(0, 2, n), np.ones(n)], axis=1)
    pose = rng.uniform(-1, 1, (n, 3)) * (1, 1, np.pi)
    origin, direction = rng.uniform(-1, 1, (n, 2)), rng.uniform(0, 2 * np.pi, n)
    normal = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    found = _kernel.overlap_wall(origin, normal, stadium, pose, ALERT)
    ends = pose[:, None, :2] + np.array([-1, 1])[:, None] * (stadium[:, :1] * axes(pose))[:, None]
    gap = dot(ends - origin[:, None], normal[:, None]) - stadium[:, 1:]
    gap[stadium[:, 0] == 0, 1] = np.inf
    order = np.argsort(gap > ALERT, axis=1, kind="stable")  # unused points come last
    gap = np.take_along_axis(gap, order, 1)
    ends = np.take_along_axis(ends, order[:, :, None], 1)
    seen = gap <= ALERT
    assert (found["count"] == seen.sum(axis=1)).all()
    assert (found["type"][seen[:, 0]] == OBSTACLE).all()
    assert np.abs(found["gap"] - gap)[seen].max() < ROUNDING
    middle = ends - (stadium[:, 1:] + gap / 2)[:, :, None] * normal[:, None]
    assert np.abs(found["position"] - middle)[seen].max() < ROUNDING
    assert np.abs(found["normal"] - normal[:, None])[seen].max() == 0


def box_gap(half, stadium, pose):
    """Signed distance of a core segment and the box |x| ≤ hx, |y| ≤ hy, minus the cap radius: the
    largest separation of an overlap, else the least distance of ends to box or corners to segment.
    """
    e, q = axes(pose), pose[:, :2]
    ends = [q - stadium[:, :1] * e, q + stadium[:, :1] * e]
    outside = [np.linalg.norm(np.maximum(np.abs(end) - half, 0), axis=1) for end in ends]
    corners = [half * np.array(sign) for sign in ((1, 1), (1, -1), (-1, -1), (-1, 1))]
    outside += [distance_to_segment(corner, *ends) for corner in corners]
    side = np.stack([-e[:, 1], e[:, 0]], axis=1)
    depth = [np.abs(q[:, k]) - stadium[:, 0] * np.abs(e[:, k]) - half[:, k] for k in range(2)]
    depth += [np.abs(dot(q, side)) - dot(half, np.abs(side))]
    overlap = np.max(depth, axis=0)
    return np.where(overlap <= 0, overlap, np.min(outside, axis=0)) - stadium[:, 1]


@pytest.mark.parametrize("seed", range(3))
def test_box_gap_is_the_signed_distance(seed):
    rng = np.random.default_rng(seed)
    n = PAIRS
    half, stadium = rng.uniform(0.05, 1, (n, 2)), rng.uniform(0.05, 1, (n, 2))
    stadium[: n // 8, 0] = 0
    size = np.stack([half[:, 0] + 1, half[:, 1] + 1, np.full(n, np.pi)], axis=1)
    local = rng.uniform(-1, 1, (n, 3)) * size
    quarter = np.pi / 2 * rng.integers(0, 4, n - n // 2)
    local[n // 2 :, 2] = quarter + rng.choice([0, 1e-12, 1e-6, 1e-3], n - n // 2)
    box = rng.uniform(-1, 1, (n, 3)) * (1, 1, np.pi)
    e, f = axes(box), np.stack([-np.sin(box[:, 2]), np.cos(box[:, 2])], axis=1)
    center = box[:, :2] + local[:, :1] * e + local[:, 1:2] * f
    pose = np.column_stack([center, local[:, 2] + box[:, 2]])
    found = _kernel.overlap_box(half, box, stadium, pose, ALERT)
    gap = box_gap(half, stadium, local)
    clear = np.abs(gap - ALERT) > ROUNDING
    seen = found["count"] > 0
    arrays = half, box, stadium, pose
    assert_none(clear & (seen != (gap <= ALERT)), arrays, "detection", "overlap_box")
    deepest = np.nanmin(np.where(seen[:, None], found["gap"], np.inf), axis=1)
    with np.errstate(invalid="ignore"):
        # the kernel prefers faces within 1e-12 (h_x + h_y) < 2e-12
        assert_none(seen & ~(np.abs(deepest - gap) < 3e-12), arrays, "gap", "overlap_box")
    on_box = found["position"] - 0.5 * found["gap"][:, :, None] * found["normal"] - box[:, None, :2]
    beyond = np.stack([np.abs(dot(on_box, axis[:, None])) - half[:, None, k]
                       for k, axis in enumerate((e, f))], axis=2).max(axis=2)
    # a face passes for a side within 1e-12, and the foot moves by this over the tilt of the core
    assert_none((np.nan_to_num(beyond, nan=-1) > 1e-9).any(axis=1), arrays, "off the box",
                "overlap_box")


@pytest.mark.parametrize("pose, gaps, xs", [
    pytest.param((0, 1.5, 0), [0, 0], [-0.5, 0.5], id="on the top"),
    pytest.param((1.7, 1.5, 0), [0, 0], [1.2, 2], id="overhang: end and corner"),
    pytest.param((2.3, 1.5, 0), [0, 0], [1.8, 2], id="centre beyond the edge"),
    pytest.param((2.52, 1.5, 0), [0.02 * 0.02 / 2 / 0.5], [2], id="cap on the corner"),
    pytest.param((0, 0.9, 0), [-0.6, -0.6], [-0.5, 0.5], id="deep overlap, nearest face"),
    pytest.param((0, 2, np.pi / 2), [0], [0], id="upright"),
    pytest.param((1.9, 0.9, 0), [-0.6, -0.6], [1.4, 2], id="deep overlap over the edge"),
])
def test_box_one_case_per_branch(pose, gaps, xs):
    """Stadium (0.5, 0.5) and the box |x| ≤ 2, |y| ≤ 1."""
    found = _kernel.overlap_box([(2, 1)], [(0, 0, 0)], [(0.5, 0.5)], [pose], ALERT)
    assert found["count"][0] == len(gaps) and found["type"][0] == OBSTACLE
    # the gap at the corner is a Taylor expansion
    assert found["gap"][0, : len(gaps)] == pytest.approx(gaps, abs=1e-6)
    assert found["position"][0, : len(gaps), 0] == pytest.approx(xs, abs=1e-3)


# ---- two points against four

def side_contact(points, friction, free_velocity):
    """Body 1 on the fixed body 0 at points (x, 0): centre (0, 1), mass 1, inertia 0.5."""
    arm0 = np.column_stack([points, np.zeros(len(points))])
    problem = problem_of("side contact", [(0, 0, 0), (1, 1, 2)], [(0, 0, 0), free_velocity],
                         [(0, 1)] * len(points), (0, 1), arm0, arm0 - (0, 1), friction=friction)
    return problem.solve("nlgs", tolerance=1e-14, max_iterations=100_000)


@pytest.mark.parametrize("friction", [0, 0.3, 0.8])
@pytest.mark.parametrize("seed", range(5))
def test_two_points_carry_what_four_do(friction, seed):
    """The four of the paper are pairs at the ends of the shadow, of which sums are determined."""
    rng = np.random.default_rng(seed)
    ends = np.sort(rng.uniform(-1, 1, 2))
    velocity = (rng.normal(), -1, 0.3 * rng.normal())
    two = side_contact(ends, friction, velocity)
    four = side_contact(np.repeat(ends, 2), friction, velocity)
    wrench = lambda result, x: (*result["impulse"].sum(axis=0), x @ result["impulse"][:, 0])
    message = f"ends {ends}, velocity {velocity}: {two['impulse']} and {four['impulse']}"
    assert two["residual"] < 1e-13 and four["residual"] < 1e-13, message
    # residual 1e-13 times the condition number of three balances over lever arms of 0.1 to 1
    assert wrench(four, np.repeat(ends, 2)) == pytest.approx(wrench(two, ends), abs=1e-10), message
    assert four["velocity"] == pytest.approx(two["velocity"], abs=1e-10), message

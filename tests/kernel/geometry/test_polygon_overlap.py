"""Contact points and moments of rounded polygons against independent references.

The separation of two cores along a unit vector n is min(n · vertices 2) − max(n · vertices 1). Its
largest value over all n is their signed distance. It lies at the normal of a side or along a line
of two vertices.
"""

import numpy as np
import pytest
from kernel.geometry.test_shadow_overlap import random_pairs
from rcr import _kernel

ROUNDING = 1e-12
ALERT = 0.05
CAP_CAP, CAP_SIDE, SIDE_SIDE = range(3)


# ---- shapes and poses

def random_polygon(rng, count):
    """Corners (count, 2) of a convex polygon with radii of order 1 about its centroid."""
    if count == 1:
        return np.zeros((1, 2))
    if count == 2:
        a = rng.uniform(0.1, 1)
        return np.array([[-a, 0], [a, 0]])
    while True:
        # corners of a polygon inscribed in an ellipse
        angle = np.sort(rng.uniform(0, 2 * np.pi, count))
        corners = np.column_stack([np.cos(angle), rng.uniform(0.2, 1) * np.sin(angle)])
        sides = np.roll(corners, -1, axis=0) - corners
        if np.hypot(*sides.T).min() > 0.4 / count**2:
            return corners - np.array(_kernel.polygon_moments(corners, 0)[1])


def in_plane(corners, pose):
    """Corners of a shape at poses (N, 3), (N, n, 2)."""
    c, s = np.cos(pose[:, 2:]), np.sin(pose[:, 2:])
    x, y = corners.T
    return np.stack([pose[:, :1] + c * x - s * y, pose[:, 1:2] + s * x + c * y], axis=-1)


def near_poses(rng, one, two, radii, count):
    """Poses at which two cores come close: random, flush sides, and deep overlaps."""
    angle1 = rng.uniform(-np.pi, np.pi, count)
    angle2 = rng.uniform(-np.pi, np.pi, count)
    flush = rng.random(count) < 0.5
    if len(one) > 1 and len(two) > 1:  # the second turned so that two sides face each other
        def side(corners):
            k = rng.integers(0, len(corners), count)
            edge = np.roll(corners, -1, axis=0)[k] - corners[k]
            return np.arctan2(edge[:, 1], edge[:, 0])
        tilt = rng.choice([0, 1e-15, 1e-9, 1e-6, 1e-3, 1e-2], count)
        angle2[flush] = (angle1 + side(one) - side(two) + np.pi + tilt)[flush]
    towards = rng.uniform(-np.pi, np.pi, count)
    n = np.column_stack([np.cos(towards), np.sin(towards)])
    pose1 = np.column_stack([rng.uniform(-1, 1, (count, 2)), angle1])
    pose2 = np.column_stack([pose1[:, :2], angle2])
    # apart along n by the reach of both, then by the signed distance once more
    reach = np.einsum("pni,pi->pn", in_plane(one, pose1) - pose1[:, None, :2], n).max(axis=1)
    reach2 = np.einsum("pni,pi->pn", in_plane(two, pose2) - pose2[:, None, :2], n).min(axis=1)
    pose2[:, :2] += (reach - reach2)[:, None] * n
    distance = separation(in_plane(one, pose1), in_plane(two, pose2))[0]
    gap = rng.uniform(-0.5, 1.2, count) * ALERT
    deep = rng.random(count) < 0.1
    move = np.where(deep, -rng.uniform(0, 1, count), radii + gap - distance)
    pose2[:, :2] += move[:, None] * n
    return pose1, pose2


# ---- references

def separation(one, two):
    """Signed distance (N,) of cores (N, n, 2) and (N, m, 2), and the unit vector (N, 2) of it."""
    normals = []
    for core, sign in ((one, 1), (two, -1)):
        if core.shape[1] > 1:
            edge = np.roll(core, -1, axis=1) - core
            normals.append(sign * np.stack([edge[..., 1], -edge[..., 0]], axis=-1))
    between = two[:, None] - one[:, :, None]
    normals.append(between.reshape(len(one), -1, 2))
    normal = np.concatenate(normals, axis=1)
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    normal = normal / np.where(length > 1e-12, length, np.inf)
    value = (np.einsum("pki,pmi->pkm", normal, two).min(axis=2)
             - np.einsum("pki,pni->pkn", normal, one).max(axis=2))
    value[length[..., 0] <= 1e-12] = -np.inf
    best = value.argmax(axis=1)
    rows = np.arange(len(one))
    return value[rows, best], normal[rows, best]


def profile(core, normal, tangent, along):
    """Largest n · x over the points x of a core with t · x = along; −∞ beside the core."""
    ends = np.stack([core, np.roll(core, -1, axis=0)])
    s, h = ends @ tangent, ends @ normal
    span = s[1] - s[0]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(span != 0, (along - s[0]) / span, 0)
    inside = (share >= -1e-9) & (share <= 1 + 1e-9) & ((span != 0) | (abs(s[0] - along) < 1e-12))
    height = np.where(inside, h[0] + share * (h[1] - h[0]), -np.inf)
    return height.max()


def cases(seed, pairs, poses, counts=(1, 2, 3, 3, 4, 4, 5, 6, 8, 12, 16, 60)):
    """Pairs of random shapes (corners, radius) with poses near contact; one has three corners."""
    rng = np.random.default_rng(seed)
    for _ in range(pairs):
        n, m = rng.choice(counts, 2)
        if max(n, m) < 3:
            n = 3
        one, two = random_polygon(rng, n), random_polygon(rng, m)
        radius1, radius2 = (rng.choice([0.0, 0.01, 0.3, 1.0]) if k > 2 else rng.uniform(0.02, 1)
                            for k in (n, m))
        yield (one, radius1, two, radius2,
               *near_poses(rng, one, two, radius1 + radius2, poses))


def overlap(case, alert=ALERT):
    one, radius1, two, radius2, pose1, pose2 = case
    return _kernel.overlap_polygons(one, radius1, pose1, two, radius2, pose2, alert)


def distance_to_outline(point, core):
    """Distance of points (N, 2) to the outline of cores (N, n, 2)."""
    start, edge = core, np.roll(core, -1, axis=1) - core
    square = np.einsum("pni,pni->pn", edge, edge)
    t = np.einsum("pni,pni->pn", point[:, None] - start, edge) / np.where(square > 0, square, 1)
    foot = start + np.clip(t, 0, 1)[..., None] * edge
    return np.linalg.norm(point[:, None] - foot, axis=2).min(axis=1)


# ---- tests

@pytest.mark.parametrize("seed", [0, 1, *(pytest.param(k, marks=pytest.mark.slow) for k in (2, 3))])
def test_gap_normal_and_points_of_random_pairs(seed):
    """25 000 pairs a seed: the first gap is the signed distance, along a normal that attains it."""
    touching = second = 0
    for case in cases(seed, 250, 100):
        one, radius1, two, radius2, pose1, pose2 = case
        core1, core2 = in_plane(one, pose1), in_plane(two, pose2)
        expected = separation(core1, core2)[0] - radius1 - radius2
        for alert in (ALERT, np.inf):
            found = overlap(case, alert)
            seen = found["count"] > 0
            clear = abs(expected - alert) > ROUNDING
            np.testing.assert_array_equal(seen[clear], (expected <= alert)[clear])
            deepest = np.nanmin(np.where(seen[:, None], found["gap"], np.inf), axis=1)
            np.testing.assert_allclose(deepest[seen], expected[seen], rtol=0, atol=ROUNDING)
        # with the alert distance of no limit, all pairs have points
        normal = found["normal"][:, 0]
        np.testing.assert_allclose(np.hypot(*normal.T), 1, rtol=0, atol=ROUNDING)
        along = (np.einsum("pi,pmi->pm", normal, core2).min(axis=1)
                 - np.einsum("pi,pni->pn", normal, core1).max(axis=1))
        np.testing.assert_allclose(along - radius1 - radius2, expected, rtol=0, atol=1e-9)
        for k in range(2):
            has = found["count"] > k
            position, gap, n = (found[x][has, k] for x in ("position", "gap", "normal"))
            on1 = position - (0.5 * gap + radius1)[:, None] * n
            on2 = position + (0.5 * gap + radius2)[:, None] * n
            assert distance_to_outline(on1, core1[has]).max(initial=0) < 1e-9
            assert distance_to_outline(on2, core2[has]).max(initial=0) < 1e-9
        touching += (expected <= ALERT).sum()
        second += (overlap(case)["count"] == 2).sum()
    assert touching > 5000 and second > 1000


def test_second_point_ends_the_shadow_on_the_flatter_side():
    """The outlines along the tangent: the gap at the nearest corner in both directions."""
    compared = 0
    for case in cases(7, 150, 20):
        one, radius1, two, radius2, pose1, pose2 = case
        core1, core2 = in_plane(one, pose1), in_plane(two, pose2)
        found = overlap(case)
        for p in np.flatnonzero(found["count"]):
            k = int(np.nanargmin(found["gap"][p]))
            normal, radii = found["normal"][p, k], radius1 + radius2
            tangent = np.array([-normal[1], normal[0]])
            start = found["position"][p, k] @ tangent
            distance = found["gap"][p, k] + radii
            ends, unsure = [], False
            for sign in (1, -1):
                # corners farther along the tangent, as far as both outlines reach
                beyond = [sign * (core @ tangent - start) for core in (core1[p], core2[p])]
                shadow = min(x.max() for x in beyond)
                if shadow < 1e-6:
                    unsure |= shadow > 1e-10
                    continue
                # the nearest corner of the facing outlines
                length = min(x for core, far, outward in ((core1[p], beyond[0], normal),
                                                          (core2[p], beyond[1], -normal))
                             for x, corner in zip(far, core) if x > 1e-6
                             and abs(profile(core, outward, tangent, corner @ tangent)
                                     - corner @ outward) < 1e-9)
                at = start + sign * length
                height = (-profile(core2[p], -normal, tangent, at)
                          - profile(core1[p], normal, tangent, at))
                ends.append(((height - distance) / length, height - radii))
            reached = [gap for _, gap in sorted(ends) if gap <= ALERT]
            if unsure or any(abs(gap - ALERT) < 1e-9 for _, gap in ends):
                continue
            if len(reached) == 2 and abs(ends[0][0] - ends[1][0]) < 1e-7:
                continue  # equally flat
            compared += 1
            assert (found["count"][p] == 2) == bool(reached), (p, ends, found["gap"][p])
            if reached:
                assert found["gap"][p, 1 - k] == pytest.approx(reached[0], abs=1e-7)
    assert compared > 800


def test_shadow_and_shallower_gap_change_as_body_2_moves():
    """Central differences along the tangent of the shallower point, where no corner rounds another."""
    kinds = {-1: 0, 0: 0, 1: 0}
    inclined = 0
    rng = np.random.default_rng(14)
    stadiums = [(one, 0.1, two, 0.2, *near_poses(rng, one, two, 0.3, 50))
                for one, two in ((random_polygon(rng, 2), random_polygon(rng, 2))
                                 for _ in range(100))]
    for case in [*cases(13, 300, 50, counts=(2, 3, 4, 6)), *stadiums]:
        one, radius1, two, radius2, pose1, pose2 = case
        found = overlap(case)
        row = np.arange(len(pose1))
        deep = np.nan_to_num(found["gap"], nan=np.inf).argmin(axis=1)
        normal = np.nan_to_num(found["normal"][row, 1 - deep])
        tangent = np.column_stack([-normal[:, 1], normal[:, 0], 0 * row])
        moved = [overlap((one, radius1, two, radius2, pose1, pose2 + way * 1e-7 * tangent))
                 for way in (1, -1)]
        usable = found["count"] == 2
        for other in moved:
            usable &= ((other["count"] == 2) & (other["slide"] == found["slide"])
                       & (abs(other["normal"] - found["normal"]).max(axis=(1, 2)) < 1e-12)
                       & (abs(other["gap"] - found["gap"]).max(axis=1) < 1e-6)
                       & (abs(other["shadow"] - found["shadow"]) < 1e-6))
        shadow, gap = (0.5e7 * (moved[0][name] - moved[1][name]) for name in ("shadow", "gap"))
        assert shadow[usable] == pytest.approx(found["slide"][usable], abs=1e-6)
        assert gap[row, 1 - deep][usable] == pytest.approx(found["slope"][usable], abs=1e-6)
        for slide in kinds:
            kinds[slide] += (found["slide"][usable] == slide).sum()
        inclined += (abs(found["slope"][usable]) > 1e-3).sum()
    assert min(kinds.values()) > 100 and inclined > 100


def test_symmetries():
    """Swapped, turned and mirrored pairs have the same points."""
    for one, radius1, two, radius2, pose1, pose2 in cases(11, 100, 100):
        found = overlap((one, radius1, two, radius2, pose1, pose2), np.inf)
        order = np.argsort(found["gap"], axis=1)

        def same(other, turn, swap=1):
            back = np.argsort(other["gap"], axis=1)
            # flush sides, equal depths along two axes and equally flat sides leave a choice
            gap, its = np.sort(found["gap"]), np.sort(other["gap"])
            np.testing.assert_allclose(its[:, 0], gap[:, 0], rtol=0, atol=ROUNDING)
            normal = np.take_along_axis(found["normal"], order[..., None], 1)[:, 0] @ turn.T
            mirrored = swap * np.take_along_axis(other["normal"], back[..., None], 1)[:, 0]
            equal = np.linalg.norm(normal - mirrored, axis=1) < 1e-6
            assert equal.mean() > 0.97

        same(overlap((two, radius2, one, radius1, pose2, pose1), np.inf), np.eye(2), -1)
        c, s = np.cos(0.7), np.sin(0.7)
        turn = np.array([[c, -s], [s, c]])
        turned = [np.column_stack([p[:, :2] @ turn.T, p[:, 2] + 0.7]) for p in (pose1, pose2)]
        same(overlap((one, radius1, two, radius2, *turned), np.inf), turn)
        mirror = np.diag([1, -1])
        mirrored = [np.column_stack([p[:, 0], -p[:, 1], -p[:, 2]]) for p in (pose1, pose2)]
        same(overlap((one[::-1] @ mirror, radius1, two[::-1] @ mirror, radius2, *mirrored), np.inf),
             mirror)


def test_gaps_change_no_faster_than_bodies_move():
    rng = np.random.default_rng(3)
    for one, radius1, two, radius2, pose1, pose2 in cases(5, 100, 50):
        size = max(np.hypot(*two.T).max(), 1e-9)
        move = rng.normal(0, 1e-4, pose2.shape)
        moved = pose2 + move
        path = np.hypot(*move[:, :2].T) + size * abs(move[:, 2])
        gaps = [np.nanmin(overlap((one, radius1, two, radius2, pose1, pose), np.inf)["gap"], axis=1)
                for pose in (pose2, moved)]
        assert (abs(gaps[1] - gaps[0]) <= path * (1 + 1e-6) + ROUNDING).all()


@pytest.mark.parametrize("shift", [0, 1e-17, 1e-12, -1e-12])
@pytest.mark.parametrize("depth", [0, 1e-17, -1e-17, 1e-6, -1e-6])
@pytest.mark.parametrize("other", [1, 0.5])
def test_flush_squares_with_a_common_corner(shift, depth, other):
    """A square on an equal one, or on the end of a larger one, bears at both ends of its side."""
    square = 0.5 * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    for turn in (0, 0.3, 1, 2.5):
        c, s = np.cos(turn), np.sin(turn)
        x, y = 0.5 - 0.5 * other + shift, 0.5 + 0.5 * other - depth
        pose = np.array([[c * x - s * y, s * x + c * y, turn]])
        found = _kernel.overlap_polygons(square, 0, np.array([[0, 0, turn]]), other * square, 0,
                                         pose, ALERT)
        assert found["count"][0] == 2 and found["type"][0] == SIDE_SIDE
        assert found["gap"][0] == pytest.approx([-depth, -depth], abs=1e-15)
        assert found["normal"][0] == pytest.approx(np.array([[-s, c]] * 2), abs=1e-12)
        along = found["position"][0] @ [c, s]
        assert np.ptp(along) == pytest.approx(other, abs=1e-9)


@pytest.mark.parametrize("angle", [0, 0.1, -0.4, 0.7])
@pytest.mark.parametrize("corner", [0.05, 0.8, 1.2])
def test_corners_that_coincide_have_a_normal(angle, corner):
    """Two triangles of this half angle touch with their corners, on one line or not."""
    triangle = np.array([[0, 0], [-1, np.tan(corner)], [-1, -np.tan(corner)]])
    for turn in np.linspace(0, 6, 17):
        pose = np.array([[0.3, -0.2, turn]]), np.array([[0.3, -0.2, turn + np.pi + angle]])
        found = _kernel.overlap_polygons(triangle, 0, pose[0], triangle, 0, pose[1], ALERT)
        assert found["count"][0] >= 1 and np.nanmin(found["gap"][0]) == pytest.approx(0, abs=1e-12)
        assert np.hypot(*found["normal"][0, 0]) == pytest.approx(1)
        assert found["normal"][0, 0] @ [np.cos(turn), np.sin(turn)] > 0


def test_polygons_on_a_floor():
    """The lowest corner, and the end of the flatter side that is within the alert distance."""
    rng = np.random.default_rng(9)
    both = 0
    for count in (3, 4, 5, 8, 16):
        corners, radius = random_polygon(rng, count), rng.choice([0, 0.1])
        turn = rng.uniform(-np.pi, np.pi, 200)
        edge = np.roll(corners, -1, axis=0) - corners
        lying = -np.arctan2(edge[:, 1], edge[:, 0])  # a side on the floor
        turn = np.concatenate([turn, lying, lying + 1e-9, lying - 1e-3])
        pose = np.column_stack([0 * turn, 0 * turn, turn])
        low = in_plane(corners, pose)[..., 1].min(axis=1)
        pose[:, 1] = radius - low + rng.uniform(-0.5, 1.2, len(turn)) * ALERT
        found = _kernel.overlap_floor(corners, radius, pose, ALERT)
        for p, placed in enumerate(in_plane(corners, pose)):
            k = placed[:, 1].argmin()
            gap = placed[k, 1] - radius
            ends = [placed[(k + step) % count] for step in (1, -1)]
            slope = [(end[1] - placed[k, 1]) / abs(end[0] - placed[k, 0]) for end in ends]
            second = sorted((s, end[1] - radius) for s, end in zip(slope, ends))
            expected = [gap] + [g for _, g in second if g <= ALERT][:1]
            if gap > ALERT:
                expected = []
            assert found["count"][p] == len(expected)
            gaps = found["gap"][p][:len(expected)]
            assert sorted(gaps) == pytest.approx(sorted(expected), abs=1e-12)
            assert found["normal"][p][:len(expected)] == pytest.approx(
                np.array([[0, 1]] * len(expected)).reshape(-1, 2))
            assert found["position"][p][:len(expected), 1] == pytest.approx(gaps / 2, abs=1e-12)
            both += len(expected) == 2
    assert both > 100


def test_radii_about_the_centre():
    rng = np.random.default_rng(2)
    for count in (1, 2, 3, 5, 16):
        corners = random_polygon(rng, count)
        radii = _kernel.polygon_radii(corners, 0.1)
        nearest = distance_to_outline(np.zeros((1, 2)), corners[None])[0] if count > 2 else 0
        assert radii == pytest.approx((np.hypot(*corners.T).max() + 0.1, nearest + 0.1))


def test_two_vertices_are_a_stadium_to_the_bit():
    stadium1, pose1, stadium2, pose2 = random_pairs(0, 2000)
    for k in range(len(pose1)):
        corners = [np.array([[-a, 0], [a, 0]]) if a > 0 else np.zeros((1, 2))
                   for a in (stadium1[k, 0], stadium2[k, 0])]
        found = _kernel.overlap_polygons(corners[0], stadium1[k, 1], pose1[k:k + 1],
                                         corners[1], stadium2[k, 1], pose2[k:k + 1], ALERT)
        expected = _kernel.overlap_stadiums(stadium1[k:k + 1], pose1[k:k + 1], stadium2[k:k + 1],
                                            pose2[k:k + 1], ALERT)
        for name, values in expected.items():
            np.testing.assert_array_equal(found[name], values)


def test_moments_against_samples():
    """Area, centroid and polar moment from the distance of grid points to the core."""
    rng = np.random.default_rng(1)
    for count, radius in ((1, 0.5), (2, 0.2), (3, 0), (3, 0.3), (4, 0.1), (6, 0.5), (16, 0.05), (60, 0)):
        corners = random_polygon(rng, count) + [0.3, -0.2]
        low, high = corners.min(axis=0) - radius, corners.max(axis=0) + radius
        step = 2e-3
        x, y = np.meshgrid(*(np.arange(low[i] + step / 2, high[i], step) for i in range(2)))
        x, y = x.ravel(), y.ravel()
        inside, near = np.full(len(x), count > 2), np.zeros(len(x), bool)
        for start, end in zip(corners, np.roll(corners, -1, axis=0)):  # all at once take gigabytes
            u, v = end - start
            dx, dy = x - start[0], y - start[1]
            inside &= v * dx - u * dy <= 0
            t = np.clip((u * dx + v * dy) / (u * u + v * v or 1), 0, 1)
            near |= (dx - t * u)**2 + (dy - t * v)**2 <= radius**2
        points = np.column_stack([x, y])[inside | near]
        area = len(points) * step**2
        found, center, moment = _kernel.polygon_moments(corners, radius)
        assert found == pytest.approx(area, rel=3e-3)
        assert center == pytest.approx(points.mean(axis=0), abs=2e-3)
        expected = area * ((points - points.mean(axis=0))**2).sum(axis=1).mean()
        assert moment == pytest.approx(expected, rel=6e-3)


def test_moments_of_known_shapes():
    square = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]]) / 2
    area, center, moment = _kernel.polygon_moments(square, 0)
    assert (area, *center, moment) == pytest.approx((1, 0, 0, 1 / 6))
    for a, r in ((0.5, 0.2), (0, 1)):
        corners = [[-a, 0], [a, 0]] if a else [[0, 0]]
        area, center, moment = _kernel.polygon_moments(corners, r)
        expected = _kernel.area(a, r), 0, 0, _kernel.polar_moment(a, r)
        assert (area, *center, moment) == pytest.approx(expected)


@pytest.mark.parametrize("corners, radius, message", [
    ([], 1, "0 vertices; expected 1 to 64"),
    ([[0, 0]], 0, "radius = 0 with 1 vertices; expected a radius > 0"),
    ([[0, 0], [0, 0]], 1, "two equal vertices"),
    ([[0, 0], [1, 0], [2, 0], [1, 1]], 0, "vertex 1 .* is not a convex corner"),
    ([[0, 0], [0, 1], [1, 0]], 0, "is not a convex corner"),  # clockwise
    ([[0, 0], [1, 0], [1, 1]], -1, "radius = -1; expected a finite length ≥ 0"),
    ([[0, 0], [np.nan, 0], [1, 1]], 0, "vertex 1 .*; expected finite coordinates"),
    (np.column_stack([np.cos(np.arange(5) * 4 * np.pi / 5), np.sin(np.arange(5) * 4 * np.pi / 5)]),
     0, "sides cross each other"),
])  # fmt: skip
def test_refused_cores(corners, radius, message):
    with pytest.raises(ValueError, match=message):
        _kernel.polygon_moments(np.reshape(corners, (-1, 2)), radius)

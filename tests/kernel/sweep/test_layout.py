"""The layout: pairs swept at once share no free body, and every pair has one place."""

import numpy as np
import pytest
from kernel.contact_problems import (REDUCTIONS, beside, discs, frictionless, grains_on_a_floor,
                                     hub, islands, pile, problem_of, square_discs, wall_of_bricks,
                                     without)
from rcr import _kernel

WIDTH, NO_SLOT = 16, -1  # slots of a block; a pair without slot
COLOURS = 16
ROLLING, FRICTIONAL, NO_LEVER, FRICTIONLESS, FRICTIONLESS_DISC = range(5)
FEW_PAIRS, MANY_PAIRS = 16, 1024  # limits of islands: all overflow; one thread

PROBLEMS = {
    "pile": lambda: pile(1), "large pile": lambda: pile(2, 40, 20),
    "bricks": lambda: wall_of_bricks(1, 12, 15), "discs": lambda: square_discs(1),
    "grains": lambda: grains_on_a_floor(40, points=2),
    "heaps": lambda: beside(pile(3, 9, 7), discs(pile(4, 9, 7)), frictionless(pile(5, 12, 9)),
                            grains_on_a_floor(5), pile(6, 2, 2)),
    "hub": lambda: hub(40), "spindle": lambda: spindle([1, 8, 64, *[512] * 9, 64, 8, 1]),
}


def spindle(layers):
    """Discs in layers; each touches up to eight of the next layer. A layer is one search level."""
    begin = np.concatenate([[0], np.cumsum(layers)])
    touch = [
        (begin[k] + i, begin[k + 1] + (8 * i + j if b > a else i // 8 if b < a else (i + j) % b))
        for k, (a, b) in enumerate(zip(layers, layers[1:]))
        for i in range(a) for j in range(8 if b >= a else 1)]
    angle = np.random.default_rng(0).uniform(0, 2 * np.pi, len(touch))
    n = np.column_stack([np.cos(angle), np.sin(angle)])
    return problem_of("spindle", np.ones((begin[-1], 3)), np.zeros((begin[-1], 3)), sorted(touch),
                      n, 0.5 * n, -0.5 * n, friction=0.4)


@pytest.fixture(scope="module", params=PROBLEMS)
def case(request):
    """A problem and its layout, with the fixed bodies and the island of each pair.

    Islands are in the order of their first pairs; −1: two driven bodies.
    """
    problem = PROBLEMS[request.param]()
    arrays = "pairs", "islands", "sections", "chunks", "blocks1", "blocks2", "records"
    layout = {key: np.array(value) if key in arrays else value
              for key, value in _kernel.layout(REDUCTIONS, **problem).items()}
    fixed, number = ~problem["inverse_mass"].any(1), {-1: -1}
    of = [number.setdefault(label, len(number) - 1)
          for label in islands(~fixed, layout["pairs"][:, :2])]
    return problem, layout | dict(fixed=fixed, of=np.array(of))


def test_pairs_join_neighbouring_points(case):
    """At most two consecutive points of the same bodies form a pair, always in the same place."""
    problem, layout = case
    again = _kernel.layout(REDUCTIONS, **problem)
    for name in "pairs", "blocks1":
        np.testing.assert_array_equal(np.array(again[name]), layout[name])
    pairs = []  # body 1, body 2, points
    for a, b in problem["bodies"].tolist():
        if pairs and pairs[-1] == [a, b, 1]:
            pairs[-1][2] = 2
        else:
            pairs.append([a, b, 1])
    np.testing.assert_array_equal(layout["pairs"][:, :3], pairs)


def test_islands_are_the_connected_parts(case):
    """Driven bodies do not connect; islands are in the order of their first pairs."""
    _, layout = case
    parts = [layout["pairs"][layout["of"] == k] for k in range(layout["of"].max() + 1)]
    expected = [(part[:, 2].sum(), len(part) > MANY_PAIRS) for part in parts]  # points, shared
    np.testing.assert_array_equal(layout["islands"][:, :2], expected)


def test_every_pair_has_a_slot_or_is_overflow(case):
    """Special bodies and small islands are overflow; pairs of driven bodies have no place."""
    problem, layout = case
    m, pairs, of = problem["inverse_mass"], layout["pairs"], layout["of"]
    regular = (m[:, 0] == m[:, 1]) & (m[:, 0] > 0)
    slots = pairs[:, 4]
    with_slot = slots[slots != NO_SLOT]
    assert len(np.unique(with_slot)) == len(with_slot)
    for island, overflow in enumerate(layout["overflow"]):
        assert sorted(overflow) == overflow, "in the order of the problem"
        np.testing.assert_array_equal(overflow, np.flatnonzero((of == island) & (slots == NO_SLOT)))
    small = np.isin(of, np.flatnonzero(np.bincount(of[of >= 0]) <= FEW_PAIRS))
    special = ~(layout["fixed"] | regular)[pairs[:, :2]].all(1) | (of < 0)
    assert (slots[small | special] == NO_SLOT).all()
    if problem.name == "hub":  # one colour per pair
        assert (slots != NO_SLOT).sum() == COLOURS
    else:
        assert (slots[~(small | special)] != NO_SLOT).all()


def test_a_pair_takes_the_lowest_colour_that_is_free_at_both_bodies(case):
    """Driven bodies take none. The chunks of a section are in the order of their colours."""
    _, layout = case
    fixed, chunks = layout["fixed"], layout["chunks"].tolist()
    of_block = [number for number, chunk in enumerate(chunks) for _ in range(chunk[1])]
    taken, found = {}, {}  # colours at a body of a section; (section, colour, …) of each chunk
    for *bodies, points, model, slot in layout["pairs"].tolist():
        if slot == NO_SLOT:
            continue
        number = of_block[slot // WIDTH]
        section = chunks[number][4]
        at = [taken.setdefault((section, b), set()) for b in bodies if not fixed[b]]
        colour = min(set(range(COLOURS)).difference(*at))
        for colours in at:
            colours.add(colour)
        found.setdefault(number, set()).add((section, colour, model, -points))
    order = [key for number in sorted(found) for key in found[number]]
    assert order == sorted(set(order)) and len(order) == len(chunks)


def bodies_of(layout, chunks):
    """Free bodies of the pairs in these chunks, with repetitions."""
    blocks = np.concatenate(
        [np.arange(first, first + count) for first, count, *_ in chunks] or [np.empty(0, int)])
    slots = layout["pairs"][:, 4]
    bodies = layout["pairs"][np.isin(slots // WIDTH, blocks) & (slots != NO_SLOT), :2].ravel()
    return bodies[~layout["fixed"][bodies]]


def test_chunks_and_sections_swept_at_once_share_no_moving_body(case):
    """Partitions, then interfaces; the records of a partition belong to its bodies alone."""
    _, layout = case
    chunks, records = layout["chunks"], layout["records"]
    for chunk in chunks:
        bodies = bodies_of(layout, [chunk])
        assert len(np.unique(bodies)) == len(bodies), f"chunk {chunk}"
    moving = lambda section: bodies_of(layout, chunks[chunks[:, 4] == section])
    for partitions_begin, partitions_end, *interfaces in layout["islands"][:, 3:]:
        for begin, end in (partitions_begin, partitions_end), interfaces:
            bodies = [np.unique(moving(section)) for section in range(begin, end)]
            if bodies:
                every = np.concatenate(bodies)
                assert len(np.unique(every)) == len(every)
        for section in range(partitions_begin, partitions_end):
            begin, end = layout["sections"][section]
            inside = np.flatnonzero((begin <= records) & (records < end))
            assert np.isin(moving(section), inside).all() and begin % 2 == end % 2 == 0
            assert (section == partitions_begin
                    or begin >= layout["sections"][section - 1][1]), "a record of two partitions"


def test_a_large_island_has_partitions_of_similar_size():
    """The interfaces have a small part of the pairs."""
    layout = _kernel.layout(REDUCTIONS, **pile(2, 100, 60))
    partitions, interfaces = np.diff(np.array(layout["islands"])[0, 3:].reshape(2, 2)).ravel()
    chunks, pairs = np.array(layout["chunks"]), np.array(layout["pairs"])
    section = np.full(len(layout["blocks1"]), -1)
    for first, count, _, _, of in chunks:
        section[first : first + count] = of
    slots = pairs[pairs[:, 4] != NO_SLOT, 4]
    sizes = np.bincount(section[slots // WIDTH], minlength=partitions + interfaces)
    assert partitions > 2 and interfaces == -(-(partitions - 1) // 4)
    assert sizes[:partitions].max() < 1.3 * sizes[:partitions].mean()
    assert sizes[partitions:].sum() < 0.15 * sizes.sum()


def test_blocks_have_one_model_and_number_of_points(case):
    _, layout = case
    chunk_of = {block: chunk for chunk in layout["chunks"].tolist()
                for block in range(chunk[0], chunk[0] + chunk[1])}
    assert len(chunk_of) == len(layout["blocks1"]), "a block belongs to one chunk"
    for _, _, points, model, slot in layout["pairs"].tolist():
        if slot != NO_SLOT:
            assert chunk_of[slot // WIDTH][2:4] == [points, model]


def test_records(case):
    """A free body has one record; each driven side and each empty slot has a separate one."""
    _, layout = case
    fixed, pairs = layout["fixed"], layout["pairs"]
    sides = np.stack([layout["blocks1"].ravel(), layout["blocks2"].ravel()])
    placed = pairs[pairs[:, 4] != NO_SLOT]
    own = np.ones(sides.shape, bool)
    for side in range(2):
        body, slot = placed[:, side], placed[:, 4]
        moves = ~fixed[body]
        np.testing.assert_array_equal(sides[side, slot[moves]], layout["records"][body[moves]])
        own[side, slot[moves]] = False
    alone = sides[own]
    assert len(np.unique(alone)) == len(alone) and not np.isin(alone, layout["records"]).any()
    assert len(np.unique(layout["records"])) == len(layout["records"])
    whole = ~np.isin(np.arange(len(fixed)), pairs[pairs[:, 3] == FRICTIONLESS_DISC][:, :2])
    assert (layout["records"][whole] % 2 == 0).all(), "a whole record begins at an even half"
    assert max([*layout["records"], *alone]) < layout["record_count"]


def test_models():
    """The cheapest model that holds; models of few pairs are not used, nor are small islands."""

    def models(problem, reductions=REDUCTIONS):
        pairs = np.array(_kernel.layout(reductions, **problem)["pairs"])
        return set(pairs[pairs[:, 4] != NO_SLOT, 3].tolist())

    assert models(square_discs(1)) == {FRICTIONLESS_DISC}
    assert models(square_discs(1), without("discs")) == {FRICTIONLESS}
    assert models(square_discs(1), without("frictionless", "discs")) == {FRICTIONAL}
    assert models(square_discs(1), without("frictionless")) == {NO_LEVER}
    discs = square_discs(1)
    discs["friction"] = np.full(len(discs["friction"]), 0.3)
    assert models(discs) == {NO_LEVER} and models(discs, without("discs")) == {FRICTIONAL}
    rough = pile(1)
    rough["friction"][:] = 0.3
    assert models(rough) == {FRICTIONAL}
    for share, expected in (0.3, {FRICTIONAL, FRICTIONLESS}), (0.1, {FRICTIONAL}):
        mixed = pile(2, 30, 12)
        pair = np.unique(mixed["bodies"], axis=0, return_inverse=True)[1].ravel()
        mixed["friction"] = np.where(
            np.random.default_rng(0).random(pair.max() + 1)[pair] < share, 0, 0.4)
        assert models(mixed) == expected, f"{share} of the pairs without friction"
    problems = grains_on_a_floor(1, points=2), hub(FEW_PAIRS), hub(FEW_PAIRS + 1)
    chunks = [_kernel.layout(REDUCTIONS, **problem)["chunks"] for problem in problems]
    assert [len(found) > 0 for found in chunks] == [False, False, True]

"""Steps of random small scenes commute with mirrors, turns, shifts, orders of bodies and units.

A step from a transformed state must give the transformed state of the step as it is. Arrays must
give the bits of engines. An error is printed with the least scene that still shows it.

    scripts/lib/run python3 tests/endurance/symmetries.py --scenes 3000 [--first 0]
"""

import cmath
import collections

import numpy as np

import children
from scene_fuzzer import O, R, solver, state
from small_scenes import advance, build, random_scene, shifts, transformed

POSITION, VELOCITY = 1e-6, 1e-5  # largest differences, over R and over the largest speed
REST = 1e-8  # R a step, below which a speed is rounding
RUN, EVERY, STEPS = 9, 3, 2  # steps of a scene, between compared states, from each of them
RELATIONS = {
    "mirrored": dict(flip=True), "turned": dict(turn=1j), "reordered": dict(step=-1),
    "in other units": dict(length=1e-3, time=1e-2, density=10), "moved": dict(shift=(7 - 3j) * R),
}  # fmt: skip


def speed(scene):
    """Largest speed of a body, of the cell and of a step of gravity, at least REST [m/s]."""
    cell = np.abs(scene["sides"]).max() * np.abs(scene["gradient"]).max() if "sides" in scene else 0
    other = cell + abs(scene["gravity"]) * scene["dt"]
    sizes = [max(p["size"] for p in b["parts"]) for b in scene["bodies"]]
    return max([abs(b["v"]) + size * (abs(b["spin"]) + REST / scene["dt"]) + other
                for b, size in zip(scene["bodies"], sizes)], default=1)


def difference(expected, found, scale, fastest):
    """Largest differences of the bodies: of positions over R, of velocities over the fastest."""
    way = motion = 0.0
    for one, two in zip(expected["bodies"], found["bodies"]):
        change = abs(one["v"] - two["v"]) + scale * R * abs(one["spin"] - two["spin"])
        motion = max(motion, change / fastest)
        for p, q in zip(one["parts"], two["parts"]):
            turn = abs(cmath.rect(1, p["angle"]) - cmath.rect(1, q["angle"]))
            way = max(way, abs(p["at"] - q["at"]) / (scale * R), turn)
    return way, motion


def broken(scene, relation, counts=None):
    """The first step that breaks the relation, as a sentence, or None; counts compared steps."""
    counts = collections.Counter() if counts is None else counts
    plain = advance(scene, STEPS)
    moves = shifts(scene, plain, relation.get("shift", 0j))
    start = transformed(scene, **{**relation, **next(moves)})
    other = advance(start, STEPS)
    counts["not converged"] += STEPS - len(plain)
    for k, end in enumerate(plain):
        if k == len(other):  # at the fine tolerance, rounding may decide
            counts["converged only as it is"] += 1
            break
        expected = transformed(end, **{**relation, **next(moves)})
        fastest = max(speed(start), speed(expected))
        way, motion = difference(expected, other[k], relation.get("length", 1), fastest)
        counts["compared"] += 1
        # corrections depend on the order of bodies
        corrected = "step" in relation and max(map(abs, end["shifts"]), default=0) > POSITION * R
        if way > POSITION and not corrected or motion > VELOCITY:
            return f"step {k}: positions differ by {way:.2g} R, velocities by {motion:.2g}"
        if corrected:
            counts["corrected"] += 1
            break
    return None


def play(scene, arrays):
    """State after a run in arrays or engines, −0 as 0, or the error; and the steps in arrays."""
    build(scene, tolerance=1e-6)
    solver().arrays = arrays
    try:
        O.run(RUN, True)
    except (ValueError, RuntimeError) as error:
        return f"{O.iter}: {error!s:.60}", 0
    return (state() + 0.0).tobytes(), solver().model["array_steps"]


def smaller(scene):
    """Scenes with a body, a motion or a property less."""
    bodies = scene["bodies"]
    for k, body in enumerate(bodies):
        yield {**scene, "bodies": bodies[:k] + bodies[k + 1 :]}
        for change in (dict(v=0j), dict(spin=0.0), dict(parts=body["parts"][:1])):
            yield {**scene, "bodies": [*bodies[:k], {**body, **change}, *bodies[k + 1 :]]}
    for change in (dict(gravity=0j), dict(friction=0.0), dict(restitution=0.0)):
        yield {**scene, **change}


def outcome(seed):
    """The relations that are broken with the least scenes, or None; and counts of steps."""
    scene, counts, wrong = random_scene(seed), collections.Counter(), []
    starts = [scene, *advance(scene, RUN)[EVERY - 1 :: EVERY]]
    for name, relation in RELATIONS.items():
        for start in starts:
            if broken(start, relation, counts):
                least = children.shrink(start, smaller, lambda scene: broken(scene, relation))
                wrong.append(f"{name}: {broken(least, relation)}\n  least: {least}")
                break
    (expected, _), (found, steps) = play(scene, False), play(scene, True)
    if expected != found:
        wrong.append("arrays differ from engines")
    return "\n".join(wrong) or None, {**counts, "in arrays": steps}


if __name__ == "__main__":
    children.main(children.parser(__doc__, 3000).parse_args(), outcome)

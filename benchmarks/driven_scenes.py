"""Driven scenes drawn at random (benchmarks.hard_scenes.driven), rigid beside springs: how many keep the bounds; table and CSV.

Run it with YADE:  scripts/yade-rcr -n -x benchmarks/driven_scenes.py --count 200 --out driven-scenes.csv
"""

import argparse
import csv
import dataclasses
from collections import Counter

from benchmarks.hard_scenes import driven


def arguments():
    parser = argparse.ArgumentParser(prog="driven_scenes.py", description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=200, metavar="N", help="scenes (default %(default)s, an hour)")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="seed of the first scene (default %(default)s)")
    parser.add_argument("--out", default="driven-scenes.csv", metavar="FILE", help="CSV (default %(default)s)")
    parser.add_argument("--springs", metavar="FILE", help="CSV of an earlier run, whose courses of springs are taken: they cost most of the time")
    options = parser.parse_args()
    if options.count < 1:
        parser.error(f"--count {options.count}: give at least 1")
    options.known = courses(options.springs) if options.springs else {}
    return options


def courses(path):
    """Of the springs, by seed, in a CSV of this script; an older one may have fewer columns."""
    value = {float: float, int: int, bool: "True".__eq__}
    fields = dataclasses.fields(driven.Course)
    course = lambda row: driven.Course(**{f.name: value[f.type](row[f"{f.name}_springs"]) for f in fields if f"{f.name}_springs" in row})
    with open(path, newline="") as file:
        return {int(row["seed"]): course(row) for row in csv.DictReader(file)}


def row(scene, rigid, springs, broken):
    """Of the table: the scene, both courses, and the names of the bounds that are broken."""
    courses = {f"{name}_{law}": value for law, course in dict(rigid=rigid, springs=springs).items() for name, value in dataclasses.asdict(course).items()}
    return dataclasses.asdict(scene) | courses | dict(broken=" ".join(broken))


def main():
    options = arguments()
    counts, yielded = Counter(), 0
    print("| seed | motion | µ | η | grains | dt | speed | v/V | F/F springs | slowest/median | without a solution | broken |\n" + "|---" * 12 + "|")
    with open(options.out, "w", newline="") as file:
        table = None
        for seed in range(options.first, options.first + options.count):
            scene = driven.draw(seed)
            rigid, springs = driven.run(scene, options.known.get(seed))
            broken = driven.violations(scene, rigid, springs)
            counts.update(broken or ["none"])
            yielded += rigid.yielded > 0
            print(
                f"| {seed} | {scene.motion} | {scene.friction:.2f} | {scene.eta:.2f} | {scene.grains} | {scene.dt:.1e} | {scene.speed:.2g} | {rigid.fastest / scene.speed:.2g} |"
                f" {rigid.force / springs.force:.2g} | {rigid.slowest / rigid.median:.2g} | {rigid.yielded} of {rigid.steps} | {' '.join(broken)} |", flush=True,
            )  # fmt: skip
            line = row(scene, rigid, springs, broken)
            if table is None:
                table = csv.DictWriter(file, line)
                table.writeheader()
            table.writerow(line)
            file.flush()
    print(f"{options.count} scenes, {yielded} with steps without a solution; bounds broken: {', '.join(f'{name} {n}' for name, n in counts.most_common())}")
    return int(set(counts) != {"none"})


raise SystemExit(main())

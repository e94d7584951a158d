"""Run driven scenes, drawn at random, under rigid contacts and springs, and check bounds.

Prints a table and writes it as CSV; benchmarks/hard_scenes/driven.py has the scenes and the bounds.

    scripts/yade-rcr -n -x benchmarks/driven_scenes.py --count 200 --out driven-scenes.csv
"""

import dataclasses
from collections import Counter

from benchmarks.hard_scenes import driven
from rcr import script
from rcr._data import files

SHOWN = ("seed", "motion", "µ", "η", "grains", "dt", "speed", "v/V", "F/F springs",
         "slowest/median", "without a solution", "broken")


def arguments():
    parser = script.Parser(prog="driven_scenes.py", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--count", type=script.at_least(1), default=200, metavar="N",
        help="number of scenes; 200 take 12 minutes")
    add("--first", type=script.integer(), default=0, metavar="SEED", help="seed of the first scene")
    add("--out", type=script.new_file, default="driven-scenes.csv", metavar="FILE", help="CSV")
    return parser.parse_args()


def row(scene, rigid, springs, broken):
    """Row of the table: scene, both courses and the names of the broken bounds."""
    courses = {f"{name}_{law}": value for law, course in dict(rigid=rigid, springs=springs).items()
               for name, value in dataclasses.asdict(course).items()}
    return dataclasses.asdict(scene) | courses | dict(broken=" ".join(broken))


def shown(scene, rigid, springs, broken):
    cells = [scene.seed, scene.motion, f"{scene.friction:.2f}", f"{scene.eta:.2f}", scene.grains,
             f"{scene.dt:.1e}", f"{scene.speed:.2g}", f"{rigid.fastest / scene.speed:.2g}",
             f"{rigid.force / springs.force:.2g}", f"{rigid.slowest / rigid.median:.2g}",
             f"{rigid.yielded} of {rigid.steps}", " ".join(broken)]
    return "| " + " | ".join(map(str, cells)) + " |"


def main():
    options = arguments()
    counts, rows = Counter(), []
    print("| " + " | ".join(SHOWN) + " |\n" + "|---" * len(SHOWN) + "|")
    for seed in range(options.first, options.first + options.count):
        scene = driven.draw(seed)
        rigid, springs = driven.run(scene)
        broken = driven.violations(scene, rigid, springs)
        counts.update(broken or ["none"])
        print(shown(scene, rigid, springs, broken), flush=True)
        rows.append(row(scene, rigid, springs, broken))
        files.write(options.out, files.table(list(rows[0]), rows))
    yielded = sum(row["yielded_rigid"] > 0 for row in rows)
    bounds = ", ".join(f"{name} {n}" for name, n in counts.most_common())
    print(f"{options.count} scenes, {yielded} with steps without a solution;",
          f"bounds broken: {bounds}")
    return int(set(counts) != {"none"})


raise SystemExit(main())

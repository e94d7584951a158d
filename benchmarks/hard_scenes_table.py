"""Run the hard scenes with rigid contacts; print a table and write it as CSV.

Each scene runs with the default settings, with ten times the default time step and with a tight
solver. The exit code is 1 if a scene fails both with the defaults and with the tight solver.

Run it with YADE:  scripts/yade-rcr -n -x scripts/hard_scenes.py --out hard-scenes.csv
"""

from benchmarks import hard_scenes
from rcr import script
from rcr._data import files
from benchmarks.hard_scenes import COARSE, TIGHT

RUNS = dict(default={}, coarse=dict(dt=COARSE), tight=dict(law=TIGHT))
MEASURES = "measured gain overlap steps seconds holds stable".split()
COLUMNS = "scene title predicate bound reason".split() + [
    f"{measure}_{run}" for run in RUNS for measure in MEASURES
]


def arguments():
    parser = script.Parser(prog="hard_scenes.py", description=__doc__.splitlines()[0])
    parser.add_argument("--only", default="", metavar="NAME,…",
                        help="prefixes of scene names (default: all, some minutes)")
    parser.add_argument("--out", type=script.new_file, default="hard-scenes.csv", metavar="FILE",
                        help="CSV")
    options = parser.parse_args()
    names = sorted(hard_scenes.SCENES)
    options.names = [name for name in names if name.startswith(tuple(options.only.split(",")))]
    if not options.names:
        parser.error(f"--only {options.only}: expected prefixes of {', '.join(names)}")
    return options


def verdict(results):
    """Outcome of the predicate, with the tight solver if the defaults fail, and of 10 dt."""
    holds = lambda result: result.holds and result.stable
    tight = "holds if tight" if holds(results["tight"]) else "fails"
    first = "holds" if holds(results["default"]) else tight
    return f"{first}; {'stable' if results['coarse'].stable else 'unstable'} at 10 dt"


def main():
    options = arguments()
    print("| scene | predicate | bound | measured | at 10 dt | tight | verdict |")
    print("|---" * 7 + "|")
    rows, failed = [], []
    for name in options.names:
        module = hard_scenes.SCENES[name]
        results = {run: hard_scenes.run(name, **how) for run, how in RUNS.items()}
        measured = " | ".join(f"{result.measured:.2g}" for result in results.values())
        judged = verdict(results)
        print(f"| {name}: {module.TITLE} | {module.PREDICATE} | {module.BOUND:g} | {measured} |",
              f"{judged} |", flush=True)
        row = {key: getattr(module, key.upper()) for key in "title predicate bound reason".split()}
        row |= {f"{measure}_{run}": getattr(result, measure)
                for run, result in results.items() for measure in MEASURES}
        rows.append(dict(row, scene=name))
        files.write(options.out, files.table(COLUMNS, rows))
        failed += [name] if judged.startswith("fails") else []
    if failed:
        raise RuntimeError(f"{len(failed)} of {len(rows)} scenes fail: {', '.join(failed)}")

"""Chart d. Hard scenes (`benchmarks.hard_scenes`) over dt, with rigid contacts and with springs.

    holds      the predicate of the scene is true, no energy gain, no tunnelling
    drifts     the predicate is false, no energy gain, no tunnelling
    blows up   energy gain above 5 % of the scale of the scene, tunnelling, or infinite numbers
"""

import inspect

from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from benchmarks import hard_scenes as suite

COLUMNS = "scene title law dt verdict measured bound gain overlap steps seconds".split()
DEPENDS = ("quick",)
LAWS = dict(cd=suite.ContactDynamics(), smooth=suite.Smooth())
LABELS = dict(cd="rigid", smooth="springs, E = 10⁸ Pa")
QUICK = ("s02_chain", "s04_mass", "s05", "s06_overlap", "s07_parallel_at_rest", "s08", "s12", "s13",
         "s16", "s17", "s18", "s19_tall_stack")
VERDICTS = {"holds": "#4daf4a", "drifts": "#ffcc33", "blows up": "#e41a1c", "too long": "0.85"}


def points(options):
    names = [name for name in sorted(suite.SCENES) if not options.quick or name.startswith(QUICK)]
    dts = (1e-4, 1e-3, 1e-2) if options.quick else (1e-4, 3e-4, 1e-3, 3e-3, 1e-2)
    return [f"{name}/{law}/{dt:g}" for name in names for law in LAWS for dt in dts
            if law == "cd" or not suite.SCENES[name].RIGID_ONLY]


def run(name, options):
    scene, law, dt = name.split("/")
    module = suite.SCENES[scene]
    is_long = "seconds" in inspect.signature(module.run).parameters
    shortened = dict(seconds=1.0 if options.quick else 10.0) if is_long else {}
    found = suite.run(scene, LAWS[law], float(dt), **shortened)
    verdict = "blows up" if not found.stable else "holds" if found.holds else "drifts"
    return [dict(scene=scene, title=module.TITLE, law=law, dt=float(dt), verdict=verdict,
                 measured=found.measured, bound=float(module.BOUND), gain=found.gain,
                 overlap=found.overlap, steps=found.steps, seconds=found.seconds)]


def plot(rows, options):
    failed = lambda row: "too long" if "given up" in row["status"] else "blows up"
    cell = {row["point"]: row["verdict"] if row["status"] == "ok" else failed(row) for row in rows}
    scenes = list(dict.fromkeys(point.split("/")[0] for point in points(options)))
    dts = list(dict.fromkeys(point.split("/")[2] for point in points(options)))
    figure = Figure(figsize=(2 + 0.75 * len(dts) * len(LAWS) + 3, 1.6 + 0.3 * len(scenes)))
    for ax, law in zip(figure.subplots(1, len(LAWS), sharey=True), LAWS):
        for y, scene in enumerate(scenes):
            for x, dt in enumerate(dts):
                verdict = cell.get(f"{scene}/{law}/{dt}")
                color = VERDICTS[verdict] if verdict else "w"
                ax.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=color, edgecolor="w"))
        ax.set(xlim=(-0.5, len(dts) - 0.5), ylim=(len(scenes) - 0.5, -0.5), xticks=range(len(dts)),
               xlabel="time step [s]", title=LABELS[law])
        ax.set_xticklabels([f"{float(dt):.0e}" for dt in dts], fontsize=8)
        ax.set_yticks(range(len(scenes)), [suite.title(scene) for scene in scenes], fontsize=8)
    handles = [Patch(facecolor=color, label=verdict) for verdict, color in VERDICTS.items()]
    handles += [Patch(facecolor="w", edgecolor="0.7", label="no such run")]
    figure.tight_layout(rect=(0, 0.3 / (1.6 + 0.3 * len(scenes)), 1, 1))
    figure.legend(handles=handles, ncol=5, loc="lower center", fontsize=8)
    return figure

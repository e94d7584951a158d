"""Chart b. Scenes with a known answer: error against time.

Rigid contacts vary dt and tolerance, springs vary the stiffness. Scenes and their answers:

    incline   a flat RCR slides down a slope, tan α = 0.6, µ = 0.5: x = g (sin α − µ cos α) t²/2
    disc      a disc rolls down the same slope: x = g sin α/(1 + I/(m R²)) t²/2
    ladder    a rod slides between a wall and a floor without friction, integrated numerically:
              θ'' = −m g a cos θ/(m a² + I)
    column    60 RCRs, η = 0.5, collapse beside a wall: mean x, compared with the finest setting.
              The motion is chaotic, so a setting is the mean of 4 runs with grains shifted by up
              to 0.01 R; the reference has more runs.

YADE's leapfrog moves a body at rest one step too early: x = a dt² n (n + 1)/2. Rigid contacts have
this error dt/t. `rcr.half_step_start` removes it ("half"), shown in the three scenes of smooth
motion.

Springs have k_n = K m g/R, k_s = 0.8 k_n, dt = 0.2 `rcr.critical_time_step()` and ζ = 1, which
returns e⁻² of an impact velocity; impacts of rigid contacts are plastic. The run-out of the column
is 0.072 ± 0.007 m with ζ = 0.3 (e = 0.45). With ζ = 1 it is 0.055 ± 0.002 m (K = 10⁴, 4 runs), with
rigid contacts 0.053 ± 0.001 m (dt = 1 ms, 8 runs).
"""

import math
import time
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from yade.minieigenHP import Vector3
from yade.wrapper import Omega

import rcr
from benchmarks import measure
from benchmarks.hard_scenes.stage import G, ContactDynamics, Smooth, build, material, tilted

O = Omega()
COLUMNS = "scene law dt tolerance stiffness steps seconds value reference".split()
DEPENDS = ("quick",)
FINEST = dict(dt=1e-4, tolerance=1e-6)  # reference of the column
SMOOTH_SHARE = 0.2  # time step of springs over the critical one
SMOOTH_DAMPING = 1.0
RUNS = 4  # runs of the column for each setting
TOLERANCES = 1e-2, 1e-4, 1e-8
SMOOTH_MOTION = "incline", "disc", "ladder"
STARTS = dict(cd="as YADE starts", half="from half a step")
PANELS = dict(incline="slider on an incline", disc="rolling disc",
              ladder="ladder without friction", column="collapse of a column")
EXACT = 1e-9  # smaller relative errors are rounding


# ---- scenes

def _slope(radius, eta, acceleration):
    """A grain on the slope; `acceleration` follows from the angle and the state of the grain."""
    rough, alpha = material(), math.atan(0.6)
    grain = rcr.particle((0, 0.1), radius, eta, 0, rough)
    exact = 0.5 * acceleration(alpha, grain.state) * 0.5**2
    bodies = [rcr.wall("y", 0, material=rough), grain]
    return bodies, tilted(alpha), 0.5, lambda: O.bodies[1].state.pos[0], exact


def incline(seed):
    return _slope(0.4, 0.75, lambda alpha, _: G * (math.sin(alpha) - 0.5 * math.cos(alpha)))


def disc(seed):
    return _slope(0.1, 0, lambda alpha, state: G * math.sin(alpha)
                  / (1 + state.inertia[2] / (state.mass * 0.1**2)))


def ladder(seed):
    from scipy.integrate import solve_ivp

    a, r, theta, omega, seconds = 0.5, 0.05, 1.3, -0.3, 0.4
    smooth = material(0)
    rod = rcr.particle((r + a * math.cos(theta), r + a * math.sin(theta)), a + r, a / (a + r),
                       math.pi - theta, smooth)
    m, inertia = rod.state.mass, rod.state.inertia[2]
    rod.state.vel = Vector3(-a * math.sin(theta) * omega, a * math.cos(theta) * omega, 0)
    rod.state.angVel = Vector3(0, 0, -omega)
    fall = lambda t, y: (y[1], -m * G * a * math.cos(y[0]) / (m * a * a + inertia))
    accuracy = dict(method="DOP853", rtol=1e-12, atol=1e-12)
    end = solve_ivp(fall, (0, seconds), (theta, omega), **accuracy).y[0, -1]
    bodies = [rcr.wall("y", 0, +1, material=smooth), rcr.wall("x", 0, +1, material=smooth), rod]
    turned = lambda: theta - math.asin((O.bodies[2].state.pos[1] - r) / a)
    return bodies, (0, -G, 0), seconds, turned, theta - end


def column(seed):
    R, rng = 0.02, np.random.default_rng(7)
    rough = material()
    centers = [(R + 2.05 * R * k, R + 2.05 * R * row) for row in range(10) for k in range(6)]
    angles = rng.uniform(0, math.pi, len(centers))
    shift = np.random.default_rng(seed).uniform(-1, 1, (len(centers), 2))
    centers = np.array(centers) + 0.01 * R * shift
    grains = [rcr.particle(c, R, 0.5, angle, rough) for c, angle in zip(centers, angles)]
    first = centers[:, 0].mean()
    spread = lambda: np.mean([O.bodies[2 + k].state.pos[0] for k in range(len(centers))]) - first
    walls = rcr.wall("y", 0, +1, material=rough), rcr.wall("x", 0, +1, material=rough)
    return [*walls, *grains], (0, -G, 0), 1.0, spread, ""


# Functions of a seed that return (bodies, gravity, duration, observed value, exact value).
SCENES = dict(incline=incline, disc=disc, ladder=ladder, column=column)


def _law(name, bodies, stiffness, tolerance):
    if name != "smooth":
        return ContactDynamics(dict(tolerance=tolerance, maxIterations=5000, threads=1))
    grains = [body for body in bodies if isinstance(body.shape, rcr.Rcr)]
    m = min(grain.state.mass for grain in grains)
    R = min(grain.shape.capRadius + grain.shape.halfLength for grain in grains)
    return Smooth(damping=SMOOTH_DAMPING, kn=stiffness * m * G / R)


def _simulate(scene, law, dt, tolerance, stiffness, seed):
    start = time.process_time()
    bodies, gravity, duration, observed, exact = SCENES[scene](seed)
    build(_law(law, bodies, stiffness, tolerance), dt or 1.0, *bodies, gravity=gravity)
    step = dt if law != "smooth" else SMOOTH_SHARE * rcr.critical_time_step()
    steps = math.ceil(duration / step - 1e-9)
    O.dt = duration / steps
    if law == "half":
        rcr.half_step_start()
    for _ in range(steps):
        O.step()
    return dict(steps=steps, dt=O.dt, value=float(observed()), reference=exact,
                seconds=time.process_time() - start)


# ---- the chart

def points(options):
    dts = (2e-2, 5e-3, 1e-3) if options.quick else (2e-2, 1e-2, 5e-3, 2e-3, 1e-3, 5e-4, 2e-4)
    stiffnesses = (1e2, 1e3, 1e4) if options.quick else (1e2, 1e3, 1e4, 1e5, 1e6)
    names = [f"column/reference/{seed}" for seed in range(101, 107 if options.quick else 113)]
    for scene in SCENES:
        names += [f"{scene}/cd/{dt:g}/{tolerance:g}" for dt in dts for tolerance in TOLERANCES]
        half = dts if scene in SMOOTH_MOTION else ()
        names += [f"{scene}/half/{dt:g}/{TOLERANCES[-1]:g}" for dt in half]
        names += [f"{scene}/smooth/{k:g}" for k in stiffnesses]
    return names


def run(name, options):
    scene, law, *numbers = name.split("/")
    if law == "reference":
        setting = dict(FINEST, law="cd", stiffness="", **(dict(dt=5e-4) if options.quick else {}))
    elif law != "smooth":
        setting = dict(law=law, dt=float(numbers[0]), tolerance=float(numbers[1]), stiffness="")
    else:
        setting = dict(law=law, dt="", tolerance="", stiffness=float(numbers[0]))
    seeds = [int(numbers[0])] if law == "reference" else range(RUNS if scene == "column" else 1)
    repeats = 1 if scene == "column" else 3
    simulate = lambda seed: partial(_simulate, scene, seed=seed, **setting)
    runs = [measure.best(repeats, math.inf, simulate(seed), by="seconds")[0] for seed in seeds]
    means = {key: float(np.mean([found[key] for found in runs]))
             for key in ("steps", "dt", "value", "seconds")}
    return [dict(setting, scene=scene, law=law, **means, reference=runs[0]["reference"])]


def plot(rows, options):
    rows = [row for row in rows if row["status"] == "ok"]
    figure = Figure(figsize=(10, 7.5))
    for ax, scene in zip(figure.subplots(2, 2).flat, SCENES):
        of_scene = [row for row in rows if row["scene"] == scene]
        finest = [row["value"] for row in of_scene if row["law"] == "reference"]
        reference = np.mean(finest) if finest else None
        _draw_curves(ax, of_scene, reference)
        if len(finest) > 1:  # standard error of the difference of two means
            chance = np.std(finest, ddof=1) * math.sqrt(1 / len(finest) + 1 / RUNS)
            ax.axhspan(1e-12, chance / abs(reference), color="0.9",
                       label="standard error of the difference")
            ax.set_ylim(1e-2, 1)
        ax.set_title(PANELS[scene])
        ax.set_xlabel("processor time [s]")
        ax.set_ylabel("relative error of the displacement")
        ax.grid(alpha=0.3)
        ax.legend(fontsize=7)
    figure.tight_layout()
    return figure


def _draw_curves(ax, rows, reference):
    def draw(chosen, line, label, **style):
        exact = lambda row: row["reference"] if reference is None else reference
        curve = [(row["seconds"], max(1e-12, abs(row["value"] / exact(row) - 1))) for row in chosen]
        if curve:
            ax.loglog(*np.array(curve).T, line, lw=1, label=label, **style)

    of_law = lambda law: [row for row in rows if row["law"] == law]
    for tolerance, marker in zip(TOLERANCES, "vso"):
        chosen = [row for row in of_law("cd") if row["tolerance"] == tolerance]
        draw(chosen, marker + "-", f"rigid, tolerance {tolerance:.0e}", ms=4)
    label = f"rigid, from half a step, {TOLERANCES[-1]:.0e}"
    draw(of_law("half"), "D:", label, color="0.4", ms=4)
    draw(of_law("smooth"), "k^--", "springs, K = 10² …", ms=5)


def ratios(rows):
    """Table of the errors of rigid contacts at the finest tolerance, and their order in dt."""
    rows = [row for row in rows if row["scene"] in SMOOTH_MOTION and row["law"] in STARTS
            and row["tolerance"] == TOLERANCES[-1]]
    steps = sorted({round(row["dt"], 6) for row in rows}, reverse=True)
    yield ["scene, start", *(f"{1e3 * dt:g} ms" for dt in steps), "order"]
    for scene in SMOOTH_MOTION:
        for law, start in STARTS.items():
            found = {round(row["dt"], 6): abs(row["value"] / row["reference"] - 1)
                     for row in rows if (row["scene"], row["law"]) == (scene, law)}
            if found:
                longest, shortest = max(found), min(found)
                exact = max(found.values()) < EXACT
                order = ""
                if not exact and longest > shortest:
                    growth = math.log(found[longest] / found[shortest])
                    order = f"{growth / math.log(longest / shortest):.1f}"
                cell = lambda dt: f"{found[dt]:.1e}" if dt in found else ""
                cells = ["rounding" if exact else cell(dt) for dt in steps]
                yield [f"{scene}, {start}", *cells, order]

"""Picture of a grain with its lengths, and of the contact points of pairs."""

import pathlib

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.patches import FancyArrowPatch
from rcr import geometry

CAP, HALF = 0.5, 0.5  # cap radius R' and half length of the core for R = 1: η = 0.5
POINT = dict(marker="o", color="C3", ms=6, ls="")


def grain(ax, x, y, angle=0.0):
    """Draw a grain and its core."""
    one = dict(position=[(x, y)], angle=[angle], cap_radius=[CAP], half_length=[HALF])
    columns = {name: np.array(value, float) for name, value in one.items()}
    outline = geometry.polygons(columns, points=40)
    ax.fill(*outline[0].T, facecolor="0.9", edgecolor="k", lw=1.2)
    end = HALF * np.array([np.cos(angle), np.sin(angle)])
    ax.plot([x - end[0], x + end[0]], [y - end[1], y + end[1]], "k-", lw=0.8)


def length(ax, start, end, text, at, color):
    """Draw an arrow with a text."""
    arrow = dict(arrowstyle="<->", mutation_scale=9, color=color, shrinkA=0, shrinkB=0)
    ax.add_patch(FancyArrowPatch(start, end, **arrow))
    ax.text(*at, text, color=color, ha="center")


def draw(folder):
    """Draw grain.png in a folder."""
    figure, (one, side, cap) = plt.subplots(1, 3, figsize=(9, 2.6))
    grain(one, 0, 0)
    one.add_patch(plt.Circle((0, 0), 1, fill=False, ls=":", color="0.5"))
    length(one, (0, 0), (0.8, 0.6), "R", (0.32, 0.36), "C3")
    length(one, (-HALF, 0), (-HALF, CAP), "R′", (-0.63, 0.2), "C0")
    length(one, (0, -0.1), (HALF, -0.1), "ηR", (0.25, -0.35), "C2")
    one.set_title("grain: η = (R − R′)/R")

    grain(side, 0, CAP)
    grain(side, 0.55, -CAP)
    side.fill_between([0.05, HALF], -CAP, CAP, color="C1", alpha=0.4, lw=0)
    side.plot([0.05, HALF], [0, 0], **POINT)
    side.set_title("side-side: two points\nat the ends of the shadow")

    angle = 0.7
    grain(cap, 0.3, CAP)
    grain(cap, 0.2 - HALF * np.cos(angle), -CAP - HALF * np.sin(angle), angle)
    cap.plot(0.2, 0, **POINT)
    cap.set_title("cap-side: one point")

    for ax in (one, side, cap):
        ax.set_aspect("equal")
        ax.axis("off")
    figure.savefig(pathlib.Path(folder) / "grain.png", dpi=130, bbox_inches="tight")

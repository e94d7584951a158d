"""Keys below a picture: scales of length and force above, colours of contacts and grains below."""

import matplotlib
import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator, ScalarFormatter

from rcr._pictures import drawing
from rcr._pictures.drawing import FOOT, SCALE_ROW, STRONG, TYPES, WEAK
from rcr._pictures.grain_colors import KIND_COLORS
from rcr.frame import KINDS

MOBILIZATION, OBSTACLE_CONTACT = "plasma", "0.3"  # colours of contacts
LENGTH_SHARE = 0.16  # largest length of the length scale over the width of the figure [-]
BLACK_FORCE = 3  # force of the black line of the key over the mean


def has_colors(key, contacts):
    """Return whether a key of grains or contacts needs the lower row."""
    return bool(key) or contacts in ("type", "mobilization")


def height(key, contacts):
    """Return the height of the keys [in]."""
    return SCALE_ROW + FOOT * has_colors(key, contacts)


def add(ax, frame, key, contacts, scale=None):
    """Add all keys below the picture: those of contacts on the left, of grains on the right."""
    figure = ax.figure
    add_scales(ax, FOOT * has_colors(key, contacts) + 0.5 * SCALE_ROW, scale, contacts)
    if key == "kinds":
        patches = [Patch(fc=KIND_COLORS[k], label=KINDS[k], ec="0.3", lw=0.5)
                   for k in np.unique(frame.kinds())]
        _add_legend(figure, 0.55, patches)
    elif key:
        mappable, colors = key
        _add_bar(figure, 0.57, mappable, colors.label, colors.ticks)
    if contacts == "type":
        tints = TYPES | {"obstacle": OBSTACLE_CONTACT}
        end = "corner" if (frame.grains["shape"] >= 0).all() else "cap"
        lines = [Line2D([], [], color=tint, lw=2, label=name.replace("cap", end))
                 for name, tint in tints.items()]
        _add_legend(figure, 0.0, lines)
    elif contacts == "mobilization":
        mappable = ScalarMappable(Normalize(0, 1), MOBILIZATION)
        _add_bar(figure, 0.05, mappable, r"$|f_t|/\mu f_n$")


def add_scales(ax, up, scale=None, contacts="force"):
    """Add a length scale and a `ForceScale` at a height above the bottom of the figure [in]."""
    figure, points = ax.figure, drawing.points_a_metre(ax)
    width, high = figure.get_size_inches()
    y = up / high
    length = round_below(LENGTH_SHARE * width * 72 / points)
    end = 0.02 + length * points / (72 * width)
    _add_line(figure, 0.02, end, y, color="0", lw=1.2, marker="|", ms=5, mew=0.8)
    _add_text(figure, end + 0.012, y, f"{length:g} m")
    if scale is None:
        return
    symbol = r"$\langle f_n\rangle$" if scale.is_mean else "$f_n$"
    mean = f"{symbol} = {_short(scale.force)} N/m"
    lines = [(scale.force, "0.3", mean)]
    if contacts == "force":
        above = f"above, here {_short(BLACK_FORCE * scale.force)} N/m"
        lines = [(scale.force, WEAK, f"up to {mean}"), (BLACK_FORCE * scale.force, STRONG, above)]
    for left, (force, tint, text) in zip((0.32, 0.66), lines):
        _add_line(figure, left, left + 0.05, y, color=tint, lw=points * scale.widths(force))
        _add_text(figure, left + 0.065, y, text)


def _short(number):
    """Return a number with three digits, as 1270 and not as 1.27e+03."""
    return f"{float(f'{number:.3g}'):g}"


def round_below(length):
    """Return the largest of 1, 2 and 5 times a power of ten up to a length > 0."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(f"{max(k for k in (1, 2, 5) if k * power <= length * (1 + 1e-9)) * power:.0e}")


def _add_line(figure, left, right, y, **style):
    line = Line2D([left, right], [y, y], solid_capstyle="butt", **style)
    figure.add_artist(line)


def _add_text(figure, left, y, text):
    figure.text(left, y, text, ha="left", va="center", fontsize=8)


def _add_bar(figure, left, mappable, label, ticks=None):
    """Add a colour bar below the picture, with its label and power of ten above it."""
    height = figure.get_figheight()
    scale = figure.add_axes((left, 0.17 / height, 0.38, 0.09 / height))
    numbers = ScalarFormatter(useOffset=False, useMathText=True)
    few = MaxNLocator(5, steps=[1, 2, 5, 10]) if ticks is None else ticks
    style = dict(orientation="horizontal", ticks=few, format=numbers)
    shown = figure.colorbar(mappable, cax=scale, **style)
    numbers.set_locs(shown.get_ticks())
    power = numbers.get_offset()  # part of the label: below the scale it would be cut off
    scale.xaxis.get_offset_text().set_visible(False)
    scale.tick_params(labelsize=7, pad=1, top=False)
    text = f"{label}  {power}" if power else label
    figure.text(left + 0.19, 0.29 / height, text, ha="center", va="bottom", fontsize=8)


def _add_legend(figure, left, handles):
    anchor = (left, 0.21 / figure.get_figheight())
    figure.legend(handles=handles, loc="center left", bbox_to_anchor=anchor, ncol=2, fontsize=8)

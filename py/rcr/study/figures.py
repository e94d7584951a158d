"""The figures of the paper, drawn from the analysis. Needs NumPy and Matplotlib.

Each ``plot_…(value, ax=None)`` takes the value of an observable, as `rcr.study.analysis.analyse` or analysis.json gives it, draws all its
elongations into the Axes and returns them; `draw` makes the whole figure of an observable. An elongation has the same colour and
marker in every figure, a cutoff ξ too.
"""

import matplotlib
import matplotlib.ticker
import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from rcr._drawing import COLUMN, PAGE, STYLE
from rcr.study.paper import ETAS, POLAR_ETA, nearest

MARKERS = "osD^v<>p"
XI_SHOWN = 6  # end of the ξ axes: few forces are larger
FEWEST = 1e-4  # densities below are of single contacts


def color(eta):
    """Of an elongation, dark for discs."""
    return matplotlib.colormaps["viridis"](0.93 * min(eta / max(ETAS), 1))


def marker(eta):
    return MARKERS[int(round(10 * eta)) % len(MARKERS)]


def xi_color(k, count):
    return matplotlib.colormaps["inferno"](0.85 * k / max(count - 1, 1))


def _axes(ax, width=COLUMN, **options):
    return ax if ax is not None else Figure(figsize=(width, 0.82 * width), layout="constrained").add_subplot(**options)


def _array(value, name):
    """A column of the analysis; None of the file as NaN."""
    return np.asarray(value[name], dtype=float)


def _error(value, name):
    return np.nan_to_num(_array(value, f"{name}_error"))


def eta_legend(figure, ax):
    """One legend above all axes of a figure."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4 if figure.get_figwidth() < 5 else 8)


def _curves(value, x, y, ax, band=True, **style):
    """y(x) of every elongation, with a band of one standard error."""
    for eta, row, error in zip(value["eta"], _array(value, y), _error(value, y)):
        ax.plot(_array(value, x), row, color=color(eta), label=rf"$\eta = {eta:g}$", **style)
        if band:
            ax.fill_between(_array(value, x), row - error, row + error, color=color(eta), alpha=0.2, lw=0)
    return ax


def _points(value, x, y, ax, line="", least=-np.inf, **style):
    """y(x) of every elongation as markers; values not above `least` are left out."""
    for eta, row in zip(value["eta"], _array(value, y)):
        seen = row > least
        ax.plot(_array(value, x)[seen], row[seen], line, marker=marker(eta), color=color(eta), mew=0, label=rf"$\eta = {eta:g}$", **style)
    return ax


def _by_eta(value, name, ax, label=None, style="k", mark="o", **options):
    """A number against η, with error bars."""
    ax.errorbar(value["eta"], _array(value, name), _error(value, name), color=style, marker=mark, lw=0.8, label=label, **options)
    ax.set_xlabel(r"$\eta$")
    return ax


# --- strength -----------------------------------------------------------------------------------------------------------


def plot_strain(value, ax=None):
    """sin φ against the strain [O1]."""
    ax = _axes(ax)
    for eta, row in zip(value["eta"], _array(value, "sin_phi_strain")):
        ax.plot(_array(value, "strain"), row, color=color(eta), lw=0.8, label=rf"$\eta = {eta:g}$")
    ax.set(xlabel=r"strain $\varepsilon$", ylabel=r"$\sin\varphi = q/p$", xlim=(0, _array(value, "strain")[-1]), ylim=(0, None))
    return ax


def plot_strength(value, ax=None):
    """sin φ of the critical state against η, with the paper's line [O1]."""
    ax = _axes(ax)
    line = np.array([0, 0.7])
    ax.plot(line, 0.3 + 0.3 * line, color="0.5", ls="--", label=r"paper: $0.30 + 0.30\,\eta$")
    _by_eta(value, "sin_phi", ax, label="critical state")
    ax.set(ylabel=r"$\sin\varphi$", ylim=(0, None))
    ax.legend(loc="lower right")
    return ax


# --- forces -------------------------------------------------------------------------------------------------------------


def _force_labels(suffix):
    name = "f_n" if suffix == "n" else "f_t"
    bare = name if suffix == "n" else "|f_t|"
    return rf"${bare}/\langle {bare}\rangle$", rf"$P({name})$"


def _inset(value, name, symbol, ax, place):
    inset = ax.inset_axes(place)
    _by_eta(value, name, inset, ms=2, elinewidth=0.6)
    inset.set_ylabel(symbol, labelpad=1, fontsize=8)
    inset.set_xlabel(r"$\eta$", labelpad=0, fontsize=8)
    inset.tick_params(labelsize=6.5)
    return inset


def plot_force_tail(value, ax=None, suffix="n"):
    """P(f) in log-linear scales with α(η) inset [O3, O4]."""
    ax = _axes(ax)
    x, y = _force_labels(suffix)
    _points(value, f"f_{suffix}", "pdf", ax, least=FEWEST, ms=2.5)
    ax.set(xlabel=x, ylabel=y, yscale="log", xlim=(0, 10), ylim=(FEWEST, 30))
    _inset(value, f"alpha_{suffix}", rf"$\alpha_{suffix}$", ax, (0.57, 0.6, 0.4, 0.37))
    return ax


def plot_force_power(value, ax=None, suffix="n"):
    """P(f) in log-log scales with β(η) inset [O3, O4]."""
    ax = _axes(ax)
    x, y = _force_labels(suffix)
    _points(value, f"f_{suffix}", "pdf", ax, least=FEWEST, ms=2.5)
    ax.set(xlabel=x, ylabel=y, xscale="log", yscale="log", xlim=(1e-3, 20), ylim=(FEWEST, 300 if suffix == "t" else 100))
    _inset(value, f"beta_{suffix}", rf"$\beta_{suffix}$", ax, (0.2, 0.18, 0.4, 0.37))
    return ax


def plot_mobilization(value, ax=None):
    """I_M(η) [O5]."""
    ax = _by_eta(value, "friction_mobilization", _axes(ax))
    ax.set(ylabel=r"$I_M$", ylim=(0, 1))
    return ax


def plot_strips(value, ax=None):
    """Mean normal force in vertical strips from wall to wall, over the mean of all, within a band of 10 % [beside the maps of O6]."""
    ax = _axes(ax)
    ax.axhspan(0.9, 1.1, color="0.92", lw=0)
    for eta, row, error in zip(value["eta"], _array(value, "strip_force"), _error(value, "strip_force")):
        ax.errorbar(_array(value, "strip"), row, error, color=color(eta), marker=marker(eta), ms=3, lw=0.8, elinewidth=0.6, label=rf"$\eta = {eta:g}$")
    ax.set(xlabel=r"$x/W$ (fixed wall at 0, free wall at 1)", ylabel=r"$\langle f_n\rangle_x/\langle f_n\rangle$", xlim=(0, 1))
    return ax


def plot_mobilization_by_force(value, ax=None):
    """I_mf(f_n) [O7]."""
    ax = _points(value, "f_n", "i_mf", _axes(ax), line="-", ms=2.5, lw=0.6)
    ax.set(xlabel=r"$f_n/\langle f_n\rangle$", ylabel=r"$I_{mf}$", xlim=(0, XI_SHOWN), ylim=(0, 1))
    return ax


def plot_mobilization_pdf(value, ax=None):
    """P(I_m) [O8]."""
    ax = _points(value, "i_m", "pdf", _axes(ax), line="-", ms=2.5, lw=0.6)
    ax.set(xlabel=r"$I_m$", ylabel=r"$P(I_m)$", xlim=(0, 1), yscale="log")
    ax.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    ax.yaxis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:g}"))
    ax.yaxis.set_minor_formatter(matplotlib.ticker.NullFormatter())
    return ax


# --- branch vectors -----------------------------------------------------------------------------------------------------


def plot_length_pdf(value, ax=None):
    """P(ℓ_r) of each elongation over its range; discs, all at 1, are left out [O10]."""
    ax = _axes(ax)
    for eta, row in zip(value["eta"], _array(value, "pdf")):
        seen = _array(value, "l_r") > 1 - eta
        if eta > 0:
            ax.plot(_array(value, "l_r")[seen], row[seen], color=color(eta), lw=0.8, label=rf"$\eta = {eta:g}$")
    ax.set(xlabel=r"$\ell_r$", ylabel=r"$P(\ell_r)$", ylim=(0, None), xlim=(_array(value, "l_r")[0] - 0.01, 1.005))
    return ax


def plot_correlation(value, ax=None):
    """Pearson coefficients of force and branch length against η [O12]."""
    ax = _axes(ax)
    ax.axhline(0, color="0.7", lw=0.6)
    _by_eta(value, "c_f_lr", ax, label=r"$C_{f\ell_r}$")
    _by_eta(value, "c_f_l", ax, label=r"$C_{f\ell}$", style="tab:red", mark="s")
    ax.set_ylabel("Pearson coefficient")
    ax.legend()
    return ax


def plot_force_by_length(value, ax=None, length="l_r"):
    """Mean force of classes of ℓ_r or ℓ [O13]."""
    ax = _axes(ax)
    ax.axhline(1, color="0.7", lw=0.6)
    _points(value, length, f"f_{length}", ax, line="-", ms=2, lw=0.6)
    ax.set_xlabel(r"$\ell_r$" if length == "l_r" else r"$\ell/R_{\max}$")
    ax.set_ylabel(r"$\langle f\rangle_{\ell_r}/\langle f\rangle$" if length == "l_r" else r"$\langle f\rangle_{\ell}/\langle f\rangle$")
    ax.set_ylim(0, None)
    return ax


# --- anisotropies -------------------------------------------------------------------------------------------------------


def plot_xi(value, name, symbol, ax=None):
    """A function of ξ for every elongation [O15 to O17]."""
    ax = _axes(ax)
    ax.axhline(0, color="0.7", lw=0.6)
    _curves(value, "xi", name, ax)
    ax.set(xlabel=r"$\xi$", ylabel=symbol, xlim=(0, XI_SHOWN))
    return ax


def plot_shear_stress(value, ax=None):
    """q(ξ)/p as lines, half-sums of the anisotropies as markers [O18]."""
    ax = _axes(ax)
    ax.axhline(0, color="0.7", lw=0.6)
    _curves(value, "xi", "q_over_p", ax)
    for eta, row in zip(value["eta"], _array(value, "half_sum")):
        ax.plot(_array(value, "xi")[::6], row[::6], ls="", marker=marker(eta), color=color(eta), mfc="none", mew=0.6)
    ax.set(xlabel=r"$\xi$", ylabel=r"$q(\xi)/p$", xlim=(0, XI_SHOWN))
    keys = [Line2D([], [], color="k"), Line2D([], [], color="k", ls="", marker="o", mfc="none", mew=0.6)]
    ax.legend(keys, [r"$q(\xi)/p$", "half-sum of anisotropies"], loc="upper left")
    return ax


def _xi_label(value, xi, name):
    top = _array(value, name)[-1]
    return r"$\xi = \infty$" if xi == top else rf"$\xi = {xi:g}$"


def plot_polar(theta, rows, fits, labels, ax=None):
    """Angular functions of period π and their fits as polar curves; negative values are open markers at their size.

    Parameters
    ----------
    theta : (T,) array
        Angles in [0, π) [rad].
    rows : (K, T) array
        A function for each ξ.
    fits : list of callables
        Fit of each, of an angle.
    labels : list of str
    """
    ax = _axes(ax, projection="polar")
    circle, dense = np.concatenate([theta, theta + np.pi]), np.linspace(0, 2 * np.pi, 361)
    for k, (row, fit, label) in enumerate(zip(rows, fits, labels)):
        tint, around = xi_color(k, len(rows)), np.tile(row, 2)
        ax.plot(dense, np.abs(fit(dense)), color=tint, lw=0.9)
        ax.plot(circle[around >= 0], around[around >= 0], ls="", marker=MARKERS[k], ms=2.5, color=tint, mew=0, label=label)
        ax.plot(circle[around < 0], -around[around < 0], ls="", marker=MARKERS[k], ms=2.5, color=tint, mfc="none", mew=0.5)
    quiet = np.degrees(theta[np.nanargmin(np.abs(rows[-1]))]) if np.isfinite(rows[-1]).any() else 0  # there is room for the labels
    return _polar_style(ax, quiet)


def _polar_style(ax, labels_at=None):
    """Radial labels at an angle [°], only in the outer half, where they cover nothing; none without an angle."""
    top = ax.get_ylim()[1]
    ticks = [tick for tick in matplotlib.ticker.MaxNLocator(4).tick_values(0, top) if 0 < tick < 0.85 * top]
    shown = [f"{tick:g}" if labels_at is not None and tick > 0.45 * top else "" for tick in ticks]
    ax.set_yticks(ticks, shown)
    ax.set_rlabel_position(labels_at or 0)
    ax.set_axisbelow(True)
    ax.tick_params(labelsize=7, pad=0)
    ax.grid(lw=0.3, color="0.8")
    return ax


def _polar_row(value):
    """Index of the elongation that the paper shows in polar diagrams, or the nearest."""
    return int(np.argmin(np.abs(np.asarray(value["eta"]) - nearest(value["eta"], [POLAR_ETA])[0])))


def plot_contact_directions(value, ax=None):
    """P(θ, ξ) with its Fourier fit (1 + a cos 2(θ − θ_c))/π [O14]."""
    row = _polar_row(value)
    sigma = _array(value, "theta_sigma")[row]

    def fit(amplitude, off):
        size = amplitude / np.cos(2 * off)
        return lambda theta: (1 + size * np.cos(2 * (theta - sigma - off))) / np.pi

    fits = [fit(a, off) for a, off in zip(_array(value, "amplitude")[row], _array(value, "off_axis")[row])]
    labels = [_xi_label(value, xi, "xi") for xi in _array(value, "xi")]
    return plot_polar(_array(value, "theta"), _array(value, "pdf")[row], fits, labels, ax)


def plot_vector_directions(value, name, sigma, ax=None):
    """Mean normal (…_n) or tangential (…_t) component against the direction, with its Fourier fit [O16, O17]."""
    row = _polar_row(value)
    amplitudes = _array(value, f"{name}_amplitude")[row]
    means = _array(value, f"{name}_mean")[row] if name.endswith("n") else np.zeros_like(amplitudes)
    wave = np.cos if name.endswith("n") else np.sin
    fits = [lambda theta, m=m, a=a: m + a * wave(2 * (theta - sigma)) for m, a in zip(means, amplitudes)]
    labels = [_xi_label(value, xi, "xi_polar") for xi in _array(value, "xi_polar")]
    return plot_polar(_array(value, "theta"), _array(value, name)[row], fits, labels, ax)


def plot_isotropy(value, ax=None):
    """P(θ) of every elongation after compaction, about the circle 1/π [O2]."""
    ax = _axes(ax, projection="polar")
    theta = _array(value, "theta")
    for eta, row in zip(value["eta"], _array(value, "pdf")):
        closed = np.append(np.tile(row, 2), row[0])
        ax.plot(np.linspace(theta[0], theta[0] + 2 * np.pi, len(closed)), closed, color=color(eta), lw=0.7, label=rf"$\eta = {eta:g}$")
    ax.plot(np.linspace(0, 2 * np.pi, 361), np.full(361, 1 / np.pi), "k--", lw=0.9, label=r"$1/\pi$")
    ax.set_ylim(0, None)
    return _polar_style(ax)


# --- whole figures ------------------------------------------------------------------------------------------------------


def _letters(axes):
    for letter, ax in zip("abcd", axes):
        ax.set_title(f"({letter})", loc="left", fontsize=9)


def _one(plot, projection=None, of_eta=True):
    def figure(value, analysis):
        fig = Figure(figsize=(COLUMN, 0.95 * COLUMN), layout="constrained")
        ax = plot(value, fig.add_subplot(projection=projection))
        if of_eta:
            eta_legend(fig, ax)
        return fig

    return figure


def _two(first, second):
    def figure(value, analysis):
        fig = Figure(figsize=(PAGE, 0.45 * PAGE), layout="constrained")
        axes = fig.subplots(1, 2)
        first(value, axes[0])
        second(value, axes[1])
        _letters(axes)
        eta_legend(fig, axes[0])
        return fig

    return figure


def _four(vector, names, symbols, titles):
    """Two polar diagrams, with their own legend of ξ, above two functions of ξ."""

    def figure(value, analysis):
        fig = Figure(figsize=(PAGE, 0.95 * PAGE), layout="constrained")
        upper, lower = fig.subfigures(2, 1, height_ratios=(1, 0.9))
        row = _polar_row(value)
        sigma = _array(analysis["O14"]["value"], "theta_sigma")[row]
        polar = [upper.add_subplot(1, 2, k + 1, projection="polar") for k in range(2)]
        for ax, suffix, title in zip(polar, "nt", titles):
            plot_vector_directions(value, f"{vector}_{suffix}", sigma, ax)
            ax.set_title(rf"{title}, $\eta = {value['eta'][row]:g}$" + (" (open: negative)" if suffix == "t" else ""), fontsize=8)
        upper.legend(*polar[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        axes = lower.subplots(1, 2)
        for ax, name, symbol in zip(axes, names, symbols):
            plot_xi(value, name, symbol, ax)
        _letters([*polar, *axes])
        lower.legend(*axes[0].get_legend_handles_labels(), loc="outside upper center", ncols=8)
        return fig

    return figure


def _polar(value, analysis):
    fig = Figure(figsize=(COLUMN, 1.1 * COLUMN), layout="constrained")
    ax = plot_contact_directions(value, fig.add_subplot(projection="polar"))
    ax.set_title(rf"$P_\theta(\theta, \xi)$, $\eta = {value['eta'][_polar_row(value)]:g}$", fontsize=8)
    fig.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return fig


FIGURES = dict(
    O1=_two(plot_strain, plot_strength),
    O2=_one(plot_isotropy, projection="polar"),
    O3=_two(plot_force_tail, plot_force_power),
    O4=_two(lambda value, ax: plot_force_tail(value, ax, "t"), lambda value, ax: plot_force_power(value, ax, "t")),
    O5=_one(plot_mobilization, of_eta=False),
    O6=_one(plot_strips),
    O7=_one(plot_mobilization_by_force),
    O8=_one(plot_mobilization_pdf),
    O10=_one(plot_length_pdf),
    O12=_one(plot_correlation, of_eta=False),
    O13=_two(plot_force_by_length, lambda value, ax: plot_force_by_length(value, ax, "l")),
    O14=_polar,
    O15=_one(lambda value, ax: plot_xi(value, "a_c", r"$a_c(\xi)$", ax)),
    O16=_four(
        "l",
        ("a_ln", "a_lt"),
        (r"$a_{\ell n}(\xi)$", r"$a_{\ell t}(\xi)$"),
        (r"$\langle\ell_n\rangle(\theta,\xi)/\langle\ell_n\rangle$", r"$|\langle\ell_t\rangle(\theta,\xi)|/\langle\ell_n\rangle$"),
    ),
    O17=_four(
        "f",
        ("a_fn", "a_ft"),
        (r"$a_{fn}(\xi)$", r"$a_{ft}(\xi)$"),
        (r"$\langle f_n\rangle(\theta,\xi)/\langle f_n\rangle$", r"$|\langle f_t\rangle(\theta,\xi)|/\langle f_n\rangle$"),
    ),
    O18=_one(plot_shear_stress),
)


def draw(observable, analysis):
    """The figure of an observable.

    Parameters
    ----------
    observable : str
        A key of `FIGURES`.
    analysis : dict
        As `rcr.study.analysis.analyse` returns it.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with matplotlib.rc_context(STYLE):
        return FIGURES[observable](analysis[observable]["value"], analysis)


def save(figure, stem, suffixes=("png", "pdf")):
    """Write a figure as `stem`.png and `stem`.pdf; returns the paths."""
    paths = [stem.with_name(f"{stem.name}.{suffix}") for suffix in suffixes]
    with matplotlib.rc_context(STYLE):
        for path in paths:
            figure.savefig(path)
    return paths

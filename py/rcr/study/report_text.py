"""Sentences of the report on biaxial tests: what was sheared, what came out, how sure it is.

Needs NumPy.
"""

import numpy as np

from rcr._data import checks
from rcr.observables.packings import SEEDS
from rcr.study.criteria import is_steady
from rcr.study.kinds import group_by_kind
from rcr.study.paper import AGREES, DIFFERS, NOT_TESTED
from rcr.study.protocol import HALF_RECORD

SLOW = 2e-4  # inertial number up to which a test is called slow [-]
FEWEST = 1000  # grains from which on the verdicts of the table mean something
REACHED, MOVES, UNKNOWN = "reached", "moves", "unknown"  # states of the critical state


def lead(runs, analysis, table, paper):
    """Return the five sentences at the top of the report."""
    return [_sheared(runs, analysis), paper.about, _outcome(runs, analysis, table, paper),
            _certainty(runs, analysis), _critical(runs, analysis)]


def _sheared(runs, analysis):
    value = analysis["O1"]["value"]
    etas, seeds, end = named(group_by_kind(runs)), spread(value["seeds"], "{:.0f}"), _end(runs)
    each, kinds = "each elongation", " (0 is a disc, values near 1 are needles)"
    if len(value["eta"]) == 1:
        each, kinds = "the elongation", ""
    if not _differ_in_elongation(group_by_kind(runs)):
        each, kinds = "each of" if len(value["eta"]) > 1 else "grains of", ""
    several = seeds != "1"
    packings = (f"{seeds} random packing{'s' * several} (seed{'s' * several}) of "
                f"{spread(value['particles'], '{:.0f}')} grains in two dimensions")
    start = spread([run.from_strain for run in runs], "{:.2g}")
    return (f"For {each} {etas}{kinds}, {packings} "
            f"{'were' if several else 'was'} sheared in a biaxial test (the top wall moves down, "
            f"the lateral stress is constant) up to a strain of {end}; values are means over "
            f"strains of {start} to {end}, at {_rate(runs)}.")


def _end(runs):
    return spread([float(run.networks[-1].attributes["strain"]) for run in runs], "{:.2g}")


def _rate(runs):
    """Describe the inertial number of the averages."""
    rates = [rate for (rate,) in of_summaries(runs, "inertial_number")]
    if not rates:
        return "an unknown rate"
    slow = "slow; " if max(rates) <= SLOW else ""
    return (f"an inertial number of {spread(rates, '{:.1g}')} ({slow}inertia matters from about 1e-3 "
            "on)")


def _outcome(runs, analysis, table, paper):
    value, count = analysis["O1"]["value"], verdicts(table)
    names = [kind.name for kind in group_by_kind(runs)]
    ends = [f"{value['sin_phi'][k]:.2f} at {names[k]}" for k in (0, -1)]
    measured = " and ".join(dict.fromkeys(ends))
    stated = ""
    if paper.strength:
        ends = dict.fromkeys(paper.strength(value["eta"][k]) for k in (0, -1))
        stated = f" (paper: {' and '.join(f'{strength:.2f}' for strength in ends)})"
    return (f"The shear strength sin φ = (σ₁ − σ₂)/(σ₁ + σ₂) is {measured}{stated}; "
            f"{count[AGREES]} of the {len(table)} statements of the paper below agree, "
            f"{count[DIFFERS]} do not, {count[NOT_TESTED]} are not tested.")


def _certainty(runs, analysis):
    value = analysis["O1"]["value"]
    error = np.asarray(value["sin_phi_error"], float)
    known = np.isfinite(error)
    size = f"at most {error[known].max():.1g}" if known.any() else "unknown"
    size += " where it is known" if known.any() and not known.all() else ""
    kind = ("those over the packings" if min(value["seeds"]) >= SEEDS else
            f"those within a test, which are too small, since there are fewer than {SEEDS} packings")
    small = (f"; with fewer than {FEWEST} grains, chance and walls decide many verdicts, which are "
             "therefore grey" if has_small_packing(runs) else "")
    return f"The standard error of sin φ is {size}; errors are {kind}{small}."


def _critical(runs, analysis):
    """Say for which elongations the averages are those of the critical state."""
    states, value = critical_states(runs, analysis), analysis["O15"]["value"]
    etas = {state: named([kind for kind, one in states.items() if one == state])
            for state in (REACHED, MOVES, UNKNOWN)}
    what = "The critical state, in which nothing changes any more,"
    if not approached(runs):
        return (f"{what} is not claimed: the averages begin before the slow part of the test, "
                f"which begins at a strain of {slow_strain(runs):.2g}.")
    parts = []
    if etas[REACHED]:
        parts.append(f"is reached at {etas[REACHED]} as far as the fabric shows")
    if etas[MOVES]:
        rows = [_change(*row) for state, *row in zip(
            states.values(), value["a_c_drift"], value["a_c_drift_error"]) if state == MOVES]
        parts.append(f"is not reached at {etas[MOVES]}, where the anisotropy a<sub>c</sub> of the "
                     f"contacts still changes, by {' and '.join(rows)}")
    if etas[UNKNOWN]:
        parts.append(f"is unknown at {etas[UNKNOWN]}, for want of three networks of a test")
    return f"{what} {'; it '.join(parts)}."


def slow_strain(runs):
    """Return the strain from which on all tests were slow, their largest `approach`.

    It is 0 for networks without the parameters of scripts/biaxial.py.
    """
    approaches = [run.record["parameters"].get("approach") or 0 for run in runs if run.record]
    return max(approaches, default=0)


def approached(runs):
    """Return whether the averages of all tests begin beyond the approach."""
    return min(run.from_strain for run in runs) >= slow_strain(runs) - HALF_RECORD


def critical_states(runs, analysis):
    """Return {`Kind`: whether the averages are those of the critical state}.

    It is `REACHED` if they begin beyond the approach and a_c is steady (`is_steady`), `UNKNOWN` if
    its change or the error of this is unknown, else `MOVES`.
    """
    value, beyond, states = analysis["O15"]["value"], approached(runs), {}
    columns = group_by_kind(runs), value["a_c_drift"], value["a_c_drift_error"]
    for kind, change, error in zip(*columns):
        steady = beyond and is_steady(change, error)
        known = np.isfinite([change, error]).all()
        states[kind] = MOVES if not beyond or known and not steady else (
            REACHED if known else UNKNOWN)
    return states


def listed(values, form="{:g}"):
    """Return numbers as a list in a sentence: 0, 0.4 and 0.7."""
    words = [form.format(value) for value in values]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def named(kinds):
    """Return kinds of grains as a list in a sentence: η = 0 and 0.4."""
    if _differ_in_elongation(kinds):
        return f"η = {listed([kind.eta for kind in kinds])}" if kinds else ""
    return listed([kind.name for kind in kinds], "{}")


def _differ_in_elongation(kinds):
    """Return whether kinds of grains are rounded-cap rectangles without rolling friction."""
    return all(kind.shape == "rcr" and kind.rolling_friction == 0 for kind in kinds)


def spread(values, form):
    """Return equal numbers as one, others as a range."""
    low, high = (form.format(end(values)) for end in (min, max))
    return low if low == high else f"{low} to {high}"


def verdicts(table):
    """Return {verdict: number of statements}."""
    return {verdict: sum(row.verdict == verdict for row in table)
            for verdict in (AGREES, DIFFERS, NOT_TESTED)}


def has_small_packing(runs):
    """Return whether a packing is too small for verdicts."""
    return min(run.size for run in runs) < FEWEST


def material(runs, analysis):
    """Describe the runs: size, drift, boxes, and errors of the solver."""
    value = analysis["O1"]["value"]
    strains = [float(network.attributes["strain"]) for run in runs for network in run.networks]
    columns = ("particles", "seeds", "networks", "contacts")
    form = "{}: {:.0f} particles, {} seed(s), {} networks, {} contacts"
    names = [kind.name for kind in group_by_kind(runs)]
    rows = "; ".join(form.format(*row) for row in zip(names, *(value[n] for n in columns)))
    window = f"{min(strains):.3f} to {max(strains):.3f}"
    state = f"Averages are over networks at strains from {window}. {rows}."
    return " ".join([state, _drifts(names, analysis), _boxes(runs), unconverged_steps(runs),
                     yielded_steps(runs), cost(runs)])


def _change(value, error):
    return f"{value:+.2f} ± {error:.2f}".replace("-", "−")


def _drifts(names, analysis):
    """Describe the change of a_c over the networks."""
    value = analysis["O15"]["value"]
    columns = zip(names, value["a_c_drift"], value["a_c_drift_error"])
    rows = [row for row in columns if np.isfinite(row[1])]
    if not rows:
        return "The change of a<sub>c</sub> over the strain is unknown: there are too few networks."
    text = "; ".join(f"{name}: {_change(*row)}" for name, *row in rows)
    return f"Change of a<sub>c</sub> over these strains: {text}."


def _boxes(runs):
    """Describe the shape of the box and the inertia of the sample at the ends of the tests."""
    rows = of_summaries(runs, "aspect_ratio", "sample_inertia")
    if not rows:
        return "No summary.json has the shape of the box."
    widths, inertia = zip(*rows)
    return (f"At the end the boxes are {min(widths):.1f} to {max(widths):.1f} times as wide as "
            f"high, and ρ (ε̇ W/2)² is at most {max(inertia):.1g} of σ₀.")


def cost(runs):
    """Describe the wall time and the memory of the tests."""
    rows = of_summaries(runs, "wall_seconds", "peak_memory_bytes", "seed")
    if not rows:
        return "No summary.json has the cost of its test."
    seconds, memory, seeds = zip(*rows)
    total, count = sum(seconds) / 60, len(set(seeds))
    each = f" ({total / count:.1f} min for each of {count} seeds)" if count > 1 else ""
    return (f"The tests took {total:.1f} min of wall time in all{each} and "
            f"{max(seconds) / 60:.1f} min the longest one; their largest memory was "
            f"{max(memory) / 2**30:.2f} GiB.")


def of_summaries(runs, *names):
    """Return these numbers of each run whose summary has all of them, [(number, …)]."""
    rows = [tuple(of_summary(run, name) for name in names) for run in runs]
    return [row for row in rows if None not in row]


def of_summary(run, name):
    """Return a number of a summary, None if it is missing."""
    value = (run.summary or {}).get(name)
    where = f"{run.folder / 'summary.json'}: {name}"
    return None if value is None else checks.number(where, value)


def unconverged_steps(runs):
    """Describe the steps of the shear that missed the tolerances of the solver."""
    parts = []
    for kind, group in group_by_kind(runs).items():
        rows = of_summaries(group, "missed_fraction", "missed_mean", "missed_max")
        if not rows:
            continue
        share, mean, largest = zip(*rows)
        text = "none"
        if any(share):
            error = sum(a * b for a, b in zip(share, mean)) / sum(share)
            text = (f"{100 * sum(share) / len(share):.1f} %, with estimated errors of {error:.2g} "
                    f"in the mean, {max(largest):.2g} at most")
        parts.append(f"{kind.name}: {text}")
    if not parts:
        return "No summary.json counts the steps that missed the tolerance of the solver."
    return f"Steps that missed a tolerance of the solver: {'; '.join(parts)}."


def yielded_steps(runs):
    """Describe the steps without a solution within the averages."""
    known = [run for run in runs if run.yielded is not None]
    if not known:
        return "No history counts the steps without a solution."
    parts = []
    for kind, group in group_by_kind(known).items():
        steps, marked, records, networks, _ = map(sum, zip(*(run.yielded for run in group)))
        text = f"{kind.name}: {steps}"
        if steps:
            text += f", in {marked} of {records} records, with {networks} network(s)"
        parts.append(text)
    included = any(run.yielded.included for run in known)
    use = "count in the means" if included else "are left out of the means"
    marked = any(run.yielded.steps for run in known)
    end = f" Their records and networks {use}." if marked else ""
    return f"Steps without a solution: {'; '.join(parts)}.{end}"

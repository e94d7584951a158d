"""Publish an analysis of the study, and print the numbers that its pages say in words.

    scripts/network.py campaign/runs/* --from-strain 0.3 --out analysis
    scripts/lib/run python3 docs/generate/study.py analysis campaign/runs/*

The first folder is that of `scripts/network.py`; the others are its runs. Copies `analysis.json`
and the published figures to docs/results/study; maps become JPEG. Afterwards run
docs/generate/tables.py, and compare the printed numbers with docs/study and README.md.
"""

import argparse
import pathlib
import shutil

import numpy as np
from docs.generate import tables
from PIL import Image
from rcr._data import files
from rcr.study.criteria import at_xi, last_negative, minimum

TARGET = tables.DOCS / "results" / "study"
LARGEST, QUALITY = (1600, 1200), 85  # width and height of a map [pixel], and its quality as JPEG


def publish(analysis, target):
    """Copy `analysis.json` and the figures whose names `target` has."""
    shutil.copy(analysis / "analysis.json", target)
    for figure in sorted((target / "figures").iterdir()):
        drawn = analysis / f"{figure.stem}.png"
        if figure.suffix == ".png":
            shutil.copy(drawn, figure)
            continue
        with Image.open(drawn) as whole:
            picture = whole.convert("RGB")
        picture.thumbnail(LARGEST)
        picture.save(figure, quality=QUALITY)


def _by_eta(values, digits=3):
    return ", ".join(f"{value:.{digits}f}" for value in values)


def _lowest(value, k):
    """Lowest a_c(ξ) of the k-th elongation."""
    xi, lowest, error = (column[k] for column in minimum(value, "a_c"))
    last = last_negative(value["xi"], value["a_c"][k])
    return f"{lowest:.4f} ± {error:.4f} at ξ = {xi:.2f}, negative up to {last:.2f}"


def numbers(analysis):
    """Lines with the numbers of an analysis (as of `tables.published`); lists go over η."""
    value = {name: entry["value"] for name, entry in analysis.items()}
    history, polar, force = value["O1"], value["O2"], value["O3"]
    fabric, forces, stress = value["O15"], value["O17"], value["O18"]
    strain, sin_phi = history["strain"], history["sin_phi_strain"]
    yield "η: " + _by_eta(history["eta"], 1)
    yield f"packings of each η: {_by_eta(history['seeds'], 0)}"
    yield "sin φ: " + _by_eta(history["sin_phi"])
    yield "sin φ at the start: " + _by_eta(sin_phi[:, 0])
    for first, last in (0.1, 0.2), (0.45, 0.5):
        within = (strain >= first) & (strain <= last)
        yield f"sin φ at strains of {first} to {last}: " + _by_eta(
            np.nanmean(sin_phi[:, within], axis=1))
    for k in 2, 4, 6:
        waves = np.exp(1j * k * polar["theta"])
        amplitude = 2 * np.abs(polar["pdf"] @ waves) / polar["pdf"].sum(axis=1)
        yield f"amplitude of P(θ) in {k}θ after the compaction: " + _by_eta(amplitude)
    for name in "weak_fraction", "beta_n", "beta_n_tenth":
        yield f"{name}: " + _by_eta(force[name])
    yield "I_M: " + _by_eta(value["O5"]["friction_mobilization"])
    for name in "strip_force", "strip_stress":
        strips, errors = value["O6"][name], value["O6"][f"{name}_error"]
        yield (f"{name}: up to {np.abs(strips - 1).max():.3f} from the mean, errors up to "
               f"{errors.max():.3f}, range up to {np.ptp(strips, axis=1).max():.3f}")
    bins = value["O8"]["pdf"]
    yield "share of the last bin of I_m: " + _by_eta(bins[:, -1] / bins.shape[1])
    yield "C(f, ℓ_r): " + _by_eta(value["O12"]["c_f_lr"])
    yield "C(f, ℓ): " + _by_eta(value["O12"]["c_f_l"])
    yield "lowest a_c(ξ), discs: " + _lowest(fabric, 0)
    yield f"lowest a_c(ξ), η = {fabric['eta'][1]:g}: " + _lowest(fabric, 1)
    yield "a_c(1): " + _by_eta(at_xi(fabric, "a_c")[0])
    yield "change of a_c: " + _by_eta(fabric["a_c_drift"])
    yield "error of a_c(1): " + _by_eta(at_xi(fabric, "a_c")[1])
    for xi in 0.5, 1:
        yield f"a_fn({xi}): " + _by_eta(at_xi(forces, "a_fn", xi)[0])
    yield "error of a_fn(0.5): " + _by_eta(at_xi(forces, "a_fn", 0.5)[1])
    whole, difference = stress["q_over_p"][:, -1:], stress["half_sum"] - stress["q_over_p"]
    share = np.abs(difference) / whole
    worst = share.argmax(axis=1)
    yield "q(1)/p: " + _by_eta(at_xi(stress, "q_over_p")[0])
    yield "q/p: " + _by_eta(whole[:, 0])
    yield "half-sum over q/p: " + _by_eta(1 + (difference / whole)[:, -1])
    yield "largest difference of the half-sum over q/p: " + _by_eta(share.max(axis=1))
    yield "… at ξ: " + _by_eta(stress["xi"][worst], 2)
    yield (f"… at η = {stress['eta'][-1]:g}: {difference[-1, worst[-1]]:.4f}, of which X: "
           f"{stress['cross_products'][-1, worst[-1]]:.4f}")


def costs(summaries):
    """Lines with the accuracy and the cost of runs, from their summaries."""
    def spread(name, scale=1.0):
        values = [scale * summary[name] for summary in summaries]
        return f"{min(values):.3g} to {max(values):.3g}"
    for name in ("missed_fraction", "missed_mean", "residual_max", "mean_overlap", "max_overlap",
                 "inertial_number_final"):
        yield f"{name}: {spread(name)}"
    yield f"wall time of a run [min]: {spread('wall_seconds', 1 / 60)}"
    yield f"memory [GiB]: {spread('peak_memory_bytes', 2.0**-30)}"
    shortest = {}
    for summary in summaries:
        eta, minutes = summary["eta"], summary["wall_seconds"] / 60
        shortest[eta] = min(minutes, shortest.get(eta, minutes))
    yield "shortest test of each η [min]: " + _by_eta(
        (shortest[eta] for eta in sorted(shortest)), 0)
    yield f"their sum [h]: {sum(shortest.values()) / 60:.2f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("analysis", type=pathlib.Path, help="folder of scripts/network.py")
    parser.add_argument("runs", type=pathlib.Path, nargs="+", help="run folders that it analysed")
    args = parser.parse_args()
    summaries = [files.read_json(run / "summary.json", "a summary") for run in args.runs]
    if None in summaries:
        parser.error(f"{args.runs[summaries.index(None)]} has no summary.json; expected complete runs")
    publish(args.analysis, TARGET)
    print(*numbers(tables.published("study")), sep="\n")
    print(*costs(summaries), sep="\n")


if __name__ == "__main__":
    main()

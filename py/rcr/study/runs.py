"""Results of `scripts/biaxial.py`: its networks of the critical state, its history, its isotropic state. Needs NumPy and h5py."""

import csv
import dataclasses
import json
import os
import pathlib

import numpy as np

from rcr import _checks as checks, _files as files, _results as results
from rcr.network import Network

_TWO_RUNS = "files of two runs; remove those of one"
_HISTORY = "strain", "stress_x", "stress_y"


@dataclasses.dataclass
class Run:
    """One biaxial test.

    Attributes
    ----------
    folder : pathlib.Path
    networks : list of Network
        Snapshots of the critical state, by strain.
    from_strain, to_strain : float
        Where that state is taken to start and to end [-].
    isotropic : Network or None
        End of the compaction.
    history : dict of arrays, or None
        ``strain`` [-], ``stress_x`` and ``stress_y`` on the walls [Pa], one value every record of the shear.
    record : dict or None
        run.json, which has the parameters; see `rcr._results`.
    summary : dict or None
        summary.json, of a run that is complete.
    """

    folder: pathlib.Path
    networks: list
    from_strain: float
    to_strain: float = np.inf
    isotropic: object = None
    history: object = None
    record: object = None
    summary: object = None

    @property
    def eta(self):
        return float(self.networks[0].attributes["eta"])

    @classmethod
    def read(cls, folder, from_strain=None, to_strain=None):
        """The run in a folder; the critical state ends at `to_strain`, by default the largest strain saved, and starts at `from_strain`, by default half of that.

        Raises
        ------
        ValueError
            If the folder has no network, none in the critical state, networks of several runs, or a damaged file.
        OSError
            If a file cannot be read.
        """
        folder = pathlib.Path(files.path_of("the folder", folder))
        if not folder.is_dir():
            raise ValueError(f"{folder} is no folder; wanted one written by scripts/biaxial.py")
        paths = sorted(folder.glob("network-*.h5"))
        if not paths:
            raise ValueError(f"{folder} has no network-*.h5; wanted a folder written by scripts/biaxial.py")
        networks = {path: Network.load(path) for path in paths}
        isotropic = folder / "isotropic.h5"
        initial = {isotropic: Network.load(isotropic)} if isotropic.exists() else {}
        record = results.read(folder)
        _check_one_run(networks | initial, record)
        strains = sorted(map(_strain, networks.values()))
        to_strain = np.inf if to_strain is None else checks.number("to_strain", to_strain)
        from_strain = 0.5 * min(to_strain, strains[-1]) if from_strain is None else checks.number("from_strain", from_strain)
        critical = sorted((network for network in networks.values() if from_strain <= _strain(network) <= to_strain), key=_strain)
        if not critical:
            raise ValueError(f"{folder} has no network at a strain from {from_strain:g} to {to_strain:g}; they are at {strains[0]:.4f} to {strains[-1]:.4f}")
        history = _history(folder / "history.csv")
        return cls(folder, critical, from_strain, to_strain, initial.get(isotropic), history, record, _summary(folder / "summary.json"))

    def looked_at(self, strain):
        """Does a strain, or each of several, belong to the critical state?"""
        return (strain >= self.from_strain) & (strain <= self.to_strain)

    def critical_stresses(self):
        """σ₂ and σ₁ of the records in the critical state, (rows, 2) [Pa]: σ_x and σ_y of the walls, or those of the networks without a history."""
        if self.history is not None:
            late = self.looked_at(self.history["strain"])
            if late.any():
                return np.column_stack([self.history["stress_x"], self.history["stress_y"]])[late]
        return np.array([network.principal_stresses() for network in self.networks])


def _strain(network):
    return float(network.attributes["strain"])


def _check_one_run(networks, record):
    """ValueError if the networks (by path) are not all of one run: of one packing, one elongation, one set of parameters."""
    told = record["parameters"] if record else {}
    for path, network in networks.items():
        for name in ("strain", "eta", "friction"):
            if name not in network.attributes:
                raise ValueError(f"{path} is a network without the attribute {name}; wanted networks as scripts/biaxial.py writes them")
        for name in ("eta", "seed"):
            if name in told and network.attributes.get(name) != told[name]:
                raise ValueError(f"{path} has {name} = {network.attributes.get(name)}, {path.parent / results.RUN} {told[name]}: {_TWO_RUNS}")
        if record and network.attributes.get("run", record["run"]) != record["run"]:
            raise ValueError(f"{path} is of another run than {path.parent / results.RUN}: {_TWO_RUNS}")
    (first_path, first), *others = ((path, network) for path, network in networks.items() if path.name != "isotropic.h5")
    for name in ("eta", "friction"):
        found = sorted({float(network.attributes[name]) for _, network in (*others, (first_path, first))})
        if len(found) > 1:
            listed = ", ".join(f"{value:g}" for value in found)
            raise ValueError(f"the networks in {first_path.parent} have {name} = {listed}; wanted one and the same value: {_TWO_RUNS}")
    for path, network in others:
        if not all(np.array_equal(network.particles[name], first.particles[name]) for name in ("id", "R", "mass")):
            raise ValueError(f"{path} and {first_path.name} hold different grains: {_TWO_RUNS}")
        if _strain(network) == _strain(first):
            raise ValueError(f"{path} and {first_path.name} are of the same strain: {_TWO_RUNS}")


def _history(path):
    """Columns of history.csv, None if there is no such file."""
    if not path.exists():
        return None
    with files.reading(path, "a history"):
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, strict=True)
            missing = [name for name in _HISTORY if name not in (reader.fieldnames or ())]
            if missing:
                raise ValueError(f"lacks the column {' and '.join(missing)}")
            rows = list(reader)
        if not rows:
            raise ValueError("holds no record; scripts/biaxial.py writes it anew with --resume")
        history = {name: [] for name in _HISTORY}
        for line, row in enumerate(rows, 2):
            for name in _HISTORY:
                try:
                    value = float(row[name])
                except (TypeError, ValueError):
                    raise ValueError(f"line {line}: {name} = {row[name]!r}; wanted a number") from None
                history[name].append(checks.number(f"line {line}: {name}", value))
        history = {name: np.array(column) for name, column in history.items()}
        rises = np.append(True, np.diff(history["strain"]) > 0)
        checks.require(rises, "the strain", history["strain"], "more than in the record before")
        return history


def _summary(path):
    """summary.json, None if there is no such file."""
    if not path.exists():
        return None
    with files.reading(path, "a summary"):
        summary = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(summary, dict):
            raise ValueError("holds no keys")
        return summary


def by_elongation(runs):
    """{η: its runs}, η rising: runs of the same elongation are seeds.

    Raises
    ------
    ValueError
        If the runs differ in friction, a run is there twice, or runs of one elongation differ in more than their seed.
    """
    frictions = sorted({float(network.attributes["friction"]) for run in runs for network in run.networks})
    if len(frictions) > 1:
        raise ValueError(f"the networks have friction {', '.join(f'{v:g}' for v in frictions)}; wanted one friction for all")
    groups = {eta: [run for run in runs if run.eta == eta] for eta in sorted({run.eta for run in runs})}
    for group in groups.values():
        _check_seeds(group)
    return groups


def _check_seeds(runs):
    """ValueError unless the runs are of different packings and else of the same parameters."""
    for k, run in enumerate(runs):
        for other in runs[:k]:
            if os.path.realpath(run.folder) == os.path.realpath(other.folder):
                raise ValueError(f"{run.folder} is given twice; wanted every run once")
            if run.record and other.record:
                if run.record["run"] == other.record["run"]:
                    raise ValueError(f"{run.folder} and {other.folder} hold the same run; wanted runs of different seeds")
                different = results.differing(other.record["parameters"], run.record["parameters"], ("seed", "threads", "strain", "networks"))
                if different:
                    raise ValueError(f"{other.folder} has {different.replace('here', f'{run.folder}')}; wanted runs that differ in their seed alone")

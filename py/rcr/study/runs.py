"""Results of `scripts/biaxial.py`: networks of the critical state, history, isotropic state.

Needs NumPy and h5py.
"""

import csv
import dataclasses
import json
import os
import pathlib

import numpy as np

from rcr._data import checks, files, results
from rcr.network import Network
from rcr.study.protocol import HALF_RECORD

_TWO_RUNS = "the folder mixes two runs; remove the files of one"
_HISTORY = "strain", "stress_x", "stress_y"
_YIELDED = "yielded_steps"
_FREE = "seed", "threads", "strain", "networks", "include_yielded"  # may differ between seeds


@dataclasses.dataclass
class Run:
    """One biaxial test.

    Attributes
    ----------
    folder : pathlib.Path
    networks : list of Network
        Snapshots of the critical state, by strain.
    from_strain, to_strain : float
        Start and end of the critical state [-].
    isotropic : Network or None
        End of the compaction.
    history : dict of arrays, or None
        ``strain`` [-], ``stress_x`` and ``stress_y`` on the walls [Pa] of the records of the shear.
    record : dict or None
        Contents of run.json, with the parameters; see `rcr._data.results`.
    summary : dict or None
        Contents of summary.json of a complete run.
    yielded : Yielded or None
        Steps without a solution; None if the history does not count them.
    """

    folder: pathlib.Path
    networks: list
    from_strain: float
    to_strain: float = np.inf
    isotropic: object = None
    history: object = None
    record: object = None
    summary: object = None
    yielded: object = None

    @property
    def eta(self):
        """Elongation [-]."""
        return float(self.networks[0].attributes["eta"])

    @classmethod
    def read(cls, folder, from_strain=None, to_strain=None, include_yielded=False):
        """Read the run in a folder.

        Parameters
        ----------
        folder : path
        from_strain, to_strain : float
            Critical state; by default the second half up to the largest strain saved, with half a
            record more.
        include_yielded : bool
            Keep records and snapshots whose interval has a step without a solution.

        Raises
        ------
        ValueError
            If the folder has no network, none in the critical state, networks of several runs, or
            a damaged file.
        OSError
            If a file cannot be read.
        """
        folder = pathlib.Path(files.path_of("the folder", folder))
        networks, isotropic = _networks(folder)
        record = results.read(folder)
        _check_one_run(networks | isotropic, record)
        strains = sorted(map(_strain, networks.values()))
        to_strain = np.inf if to_strain is None else checks.number("to_strain", to_strain)
        if from_strain is None:
            from_strain = 0.5 * min(to_strain, strains[-1]) - HALF_RECORD
        from_strain = checks.number("from_strain", from_strain)
        history = _history(folder / "history.csv")
        run = cls(folder, sorted(networks.values(), key=_strain), from_strain, to_strain,
                  next(iter(isotropic.values()), None), history, record,
                  _summary(folder / "summary.json"))
        run._select(include_yielded, strains)
        return run

    def _select(self, include_yielded, strains):
        """Keep the snapshots of the critical state, and only records that enter means."""
        critical = [network for network in self.networks if self.is_critical(_strain(network))]
        window = f"from {self.from_strain:g} to {self.to_strain:g}"
        if not critical:
            raise ValueError(
                f"{self.folder} has no network at a strain {window}; "
                f"they are at {strains[0]:.4f} to {strains[-1]:.4f}"
            )
        self.networks = critical
        if self.history is None or _YIELDED not in self.history:
            return
        steps = self.history.pop(_YIELDED)
        late = steps[self.is_critical(self.history["strain"])]
        marked = self.history["strain"][steps > 0]
        valid = [n for n in critical if not np.isclose(marked, _strain(n), 0, 1e-9).any()]
        self.yielded = Yielded(
            int(late.sum()), int((late > 0).sum()), len(late), len(critical) - len(valid),
            include_yielded,
        )  # fmt: skip
        if include_yielded:
            return
        self.history = {name: column[steps == 0] for name, column in self.history.items()}
        if not valid or not len(self.history["strain"]):
            raise ValueError(
                f"{self.folder}: every network at a strain {window} ends a record with a step "
                "without a solution; include them with --include-yielded, or run the test with "
                "more --iterations or a smaller --time-step"
            )
        self.networks = valid

    def is_critical(self, strain):
        """Return whether a strain, or each of an array, belongs to the critical state."""
        return (strain >= self.from_strain) & (strain <= self.to_strain)

    def critical_stresses(self):
        """Return σ₂ and σ₁ of the records in the critical state.

        Returns
        -------
        (rows, 2) float array
            σ_x and σ_y of the walls, or those of the networks without a history [Pa].
        """
        if self.history is not None:
            late = self.is_critical(self.history["strain"])
            if late.any():
                columns = self.history["stress_x"], self.history["stress_y"]
                return np.column_stack(columns)[late]
        return np.array([network.principal_stresses() for network in self.networks])


@dataclasses.dataclass(frozen=True)
class Yielded:
    """Steps without a solution in the critical state of a run.

    Attributes
    ----------
    steps : int
        Number of the steps.
    marked, records : int
        Records with such a step, and all records.
    snapshots : int
        Snapshots that end such a record.
    included : bool
        Whether they enter the means.
    """

    steps: int
    marked: int
    records: int
    snapshots: int
    included: bool


def _networks(folder):
    """Return the snapshots and the isotropic state of a folder, each as {path: Network}."""
    if not folder.is_dir():
        raise ValueError(f"{folder} is not a folder; expected one written by scripts/biaxial.py")
    paths = sorted(folder.glob("network-*.h5"))
    if not paths:
        raise ValueError(
            f"{folder} has no network-*.h5; expected a folder written by scripts/biaxial.py")
    isotropic = folder / "isotropic.h5"
    initial = {isotropic: Network.load(isotropic)} if isotropic.exists() else {}
    return {path: Network.load(path) for path in paths}, initial


def _strain(network):
    return float(network.attributes["strain"])


def _check_one_run(networks, record):
    """Raise ValueError unless all networks, by path, belong to one run."""
    for path, network in networks.items():
        _check_network(path, network, record)
    snapshots = [item for item in networks.items() if item[0].name != "isotropic.h5"]
    (first_path, first), *others = snapshots
    for name in ("eta", "friction"):
        found = sorted({float(network.attributes[name]) for _, network in snapshots})
        if len(found) > 1:
            listed = ", ".join(f"{value:g}" for value in found)
            raise ValueError(
                f"the networks in {first_path.parent} have {name} = {listed}; "
                f"expected one value: {_TWO_RUNS}"
            )
    for path, network in others:
        pairs = ((network.particles[name], first.particles[name]) for name in ("id", "R", "mass"))
        if not all(np.array_equal(*pair) for pair in pairs):
            raise ValueError(f"{path} and {first_path.name} hold different grains: {_TWO_RUNS}")
        if _strain(network) == _strain(first):
            raise ValueError(f"{path} and {first_path.name} have the same strain: {_TWO_RUNS}")


def _check_network(path, network, record):
    """Raise ValueError if a network lacks an attribute or contradicts run.json."""
    attributes = network.attributes
    for name in ("strain", "eta", "friction", "volume"):
        if name not in attributes:
            raise ValueError(
                f"{path} is a network without the attribute {name}; expected strain, eta, friction "
                "and volume, as scripts/biaxial.py stores them"
            )
    if not record:
        return
    for name in ("eta", "seed"):
        recorded = record["parameters"].get(name, attributes.get(name))
        if attributes.get(name) != recorded:
            raise ValueError(
                f"{path} has {name} = {attributes.get(name)}, "
                f"{path.parent / results.RUN} {recorded}: {_TWO_RUNS}"
            )
    if attributes.get("run", record["run"]) != record["run"]:
        raise ValueError(f"{path} and {path.parent / results.RUN} have different runs: {_TWO_RUNS}")


def _history(path):
    """Return columns of history.csv, None if there is no such file; stress_y holds σ₁."""
    if not path.exists():
        return None
    with files.reading(path, "a history"):
        with open(path, newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file, strict=True)
            present = reader.fieldnames or ()
            missing = [name for name in _HISTORY if name not in present]
            if missing:
                raise ValueError(f"lacks the column {' and '.join(missing)}")
            rows = list(reader)
        if not rows:
            raise ValueError("holds no record; scripts/biaxial.py --resume writes it again")
        names = [*_HISTORY, *([_YIELDED] if _YIELDED in present else [])]
        history = {
            name: np.array([_value(line, name, row) for line, row in enumerate(rows, 2)])
            for name in names
        }
        rises = np.append(True, np.diff(history["strain"]) > 0)
        checks.require(rises, "the strain", history["strain"], "more than in the record before")
        if history["stress_x"].mean() > history["stress_y"].mean():  # σ₁ is along x
            history["stress_x"], history["stress_y"] = history["stress_y"], history["stress_x"]
        return history


def _value(line, name, row):
    """Return a number of history.csv."""
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        raise ValueError(f"line {line}: {name} = {row[name]!r}; expected a number") from None
    return checks.number(f"line {line}: {name}", value)


def _summary(path):
    """Return the contents of summary.json, None if there is no such file."""
    if not path.exists():
        return None
    with files.reading(path, "a summary"):
        summary = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(summary, dict):
            raise ValueError("holds no keys")
        return summary


def by_elongation(runs):
    """Return {η: its runs}, η rising; runs of one elongation are seeds.

    Raises
    ------
    ValueError
        If the runs differ in friction, a run is given twice, or runs of one elongation differ in
        more than their seed.
    """
    networks = [network for run in runs for network in run.networks]
    frictions = sorted({float(network.attributes["friction"]) for network in networks})
    if len(frictions) > 1:
        listed = ", ".join(f"{v:g}" for v in frictions)
        raise ValueError(f"the networks have friction {listed}; expected one friction for all")
    etas = sorted({run.eta for run in runs})
    groups = {eta: [run for run in runs if run.eta == eta] for eta in etas}
    for group in groups.values():
        _check_seeds(group)
    return groups


def _check_seeds(runs):
    """Raise ValueError unless the runs have different packings and else the same parameters."""
    for k, run in enumerate(runs):
        for other in runs[:k]:
            if os.path.realpath(run.folder) == os.path.realpath(other.folder):
                raise ValueError(f"{run.folder} is given twice; expected every run once")
            if run.record and other.record:
                _check_records(run, other)


def _check_records(run, other):
    if run.record["run"] == other.record["run"]:
        raise ValueError(
            f"{run.folder} and {other.folder} hold the same run; expected runs of different seeds")
    parameters = other.record["parameters"], run.record["parameters"]
    different = results.differing(*parameters, _FREE)
    if different:
        raise ValueError(
            f"{other.folder} has {different.replace('(here ', f'({run.folder} ')}; "
            "expected runs that differ in their seed alone"
        )

"""Results of `scripts/biaxial.py`: networks of the critical state, history, isotropic state.

Needs NumPy and h5py.
"""

import dataclasses
import itertools
import math
import os
import pathlib
import typing

import numpy as np

from rcr._data import checks, files, run_folder
from rcr.network import Network
from rcr.ensemble import common_value
from rcr.study.kinds import Kind, group_by_kind
from rcr.study.protocol import HALF_RECORD, SHAPES, critical_start, is_critical

_TWO_RUNS = "the folder mixes two runs; remove the files of one"
_HISTORY = "strain", "stress_x", "stress_y"
_YIELDED = "yielded_steps"
_MOST_OBLIQUE = 20  # angle of σ₁ to x or y, at most [°]; it lowers sin φ of the walls by 23 %
_FREE = "seed", "threads", "strain", "networks", "include_yielded"  # may differ between seeds
_FREE_OF_KIND = (  # may differ between elongations, and between kinds that are compared
    *_FREE, "eta", "particles", "iterations", "shape", "sides", "rolling_friction")
_WINDOW_SHARE = 0.1  # difference of the windows of two elongations over their length, at most [-]


class Yielded(typing.NamedTuple):
    """Steps without a solution in the critical state of a run."""

    steps: int
    marked: int  # records with a step without a solution
    records: int  # all records
    networks: int  # those at the end of a marked record
    included: bool  # whether they enter the means


@dataclasses.dataclass
class Run:
    """One biaxial test."""

    folder: pathlib.Path
    networks: list  # of the critical state, by strain
    from_strain: float  # start of the critical state [-]
    to_strain: float = np.inf  # its end [-]
    isotropic: Network = None  # end of the compaction
    history: dict = None  # records of the shear: strain [-], σ₂ stress_x, σ₁ stress_y [Pa]
    record: dict = None  # contents of run.json, with the parameters
    summary: dict = None  # contents of summary.json of a complete run
    yielded: Yielded = None  # None if the history does not count the steps without a solution

    @property
    def eta(self):
        """Elongation [-]."""
        return common_value(self.networks, "eta")

    @property
    def size(self):
        """Number of grains; members of a clump are one."""
        clump = self.networks[0].particles["clump"]
        return int((clump < 0).sum()) + len(np.unique(clump[clump >= 0]))

    @property
    def kind(self):
        """The `Kind` of its grains."""
        return Kind.of(self.networks[0].attributes, self.eta)

    @classmethod
    def read(cls, folder, from_strain=None, to_strain=None, include_yielded=False, averages=0.5):
        """Read the run in a folder.

        The critical state is by default from the share `averages` of the largest strain saved up to
        this strain. It has half a record more at both ends. `include_yielded` keeps records and
        networks whose interval has a step without a solution. A ValueError reports a damaged file,
        networks of several runs, or no network in the critical state.
        """
        folder = pathlib.Path(files.path_of("the folder", folder))
        networks, isotropic = _networks(folder)
        record = run_folder.read(folder)
        if record and record["program"] != "biaxial.py":
            raise ValueError(f"{folder / run_folder.RUN} is of {record['program']}; expected a folder "
                             "of scripts/biaxial.py, or networks without this file")
        _check_one_run(networks, isotropic, record)
        ordered = sorted(networks.values(), key=_strain)
        last = _strain(ordered[-1])
        to_strain = last if to_strain is None else min(last, checks.number("to_strain", to_strain))
        start = critical_start(to_strain, averages) if from_strain is None else from_strain
        from_strain = checks.number("from_strain", start)
        run = cls(folder, ordered, from_strain, to_strain, next(iter(isotropic.values()), None),
                  _history(folder / "history.csv"), record,
                  files.read_json(folder / "summary.json", "a summary"))
        run._select(include_yielded)
        return run

    def _select(self, include_yielded):
        """Keep the networks of the critical state, and only records that enter means."""
        critical = [network for network in self.networks if self.is_critical(_strain(network))]
        window = f"from {self.from_strain:g} to {self.to_strain:g}"
        if not critical:
            first, last = _strain(self.networks[0]), _strain(self.networks[-1])
            raise ValueError(f"{self.folder} has no network at a strain {window}; "
                             f"they are at {first:.4f} to {last:.4f}")
        self.networks = critical
        if self.history is None:
            return
        self._check_history()
        if _YIELDED in self.history:
            self._select_solved(window, include_yielded)
        self._align_history()

    def _select_solved(self, window, include_yielded):
        """Count the steps without a solution; leave out their records and networks."""
        steps, critical = self.history.pop(_YIELDED), self.networks
        late = steps[self.is_critical(self.history["strain"])]
        marked = self.history["strain"][steps > 0]
        valid = [n for n in critical if not np.isclose(marked, _strain(n), 0, 1e-9).any()]
        self.yielded = Yielded(int(late.sum()), int((late > 0).sum()), len(late),
                               len(critical) - len(valid), include_yielded)
        if include_yielded:
            return
        self.networks = valid
        self.history = {name: column[steps == 0] for name, column in self.history.items()}
        if not valid or not self.is_critical(self.history["strain"]).any():
            raise ValueError(
                f"{self.folder}: every record at a strain {window}, or that of every network, has "
                "a step without a solution; include them with --include-yielded, or run the test "
                "with more --iterations or a smaller --time-step")

    def _check_history(self):
        """Raise ValueError if the history ends before the networks of the critical state."""
        end, last = self.history["strain"][-1], _strain(self.networks[-1])
        if end < last - HALF_RECORD or not self.is_critical(self.history["strain"]).any():
            raise ValueError(
                f"{self.folder / 'history.csv'} ends at a strain of {end:.4f} and the networks at "
                f"{last:.4f}; expected records up to there: write it again with scripts/biaxial.py "
                "--resume, or remove it to take sin φ from the networks")

    def _align_history(self):
        """Exchange the columns of the history if σ₁ is along x, so that stress_y holds σ₁.

        A ValueError says that σ₁ of the networks is along neither axis.
        """
        stress = np.sum([network.stress() for network in self.networks], axis=0)
        shear, difference = stress[0, 1] + stress[1, 0], stress[0, 0] - stress[1, 1]
        angle = 0.5 * np.degrees(np.arctan2(shear, difference)) % 180
        if _MOST_OBLIQUE < angle % 90 < 90 - _MOST_OBLIQUE:
            raise ValueError(
                f"{self.folder / 'history.csv'} has the stresses along x and y; the axis of σ₁ of "
                f"the networks is at {angle:.0f}° to x; expected at most {_MOST_OBLIQUE}° to x or "
                "y: remove history.csv to take sin φ from the networks")
        x, y = self.history["stress_x"], self.history["stress_y"]
        late = self.is_critical(self.history["strain"])
        if x[late].mean() > y[late].mean():
            self.history |= dict(stress_x=y, stress_y=x)

    def is_critical(self, strain):
        """Return whether a strain, or each of an array, belongs to the critical state."""
        return is_critical(strain, self.from_strain, self.to_strain)

    def critical_stresses(self):
        """Return σ₂ and σ₁ of the records in the critical state, (rows, 2) [Pa].

        They are those of the walls, or without a history those of the networks.
        """
        if self.history is None:
            return np.array([network.principal_stresses() for network in self.networks])
        columns = self.history["stress_x"], self.history["stress_y"]
        return np.column_stack(columns)[self.is_critical(self.history["strain"])]


def _networks(folder):
    """Return networks of the shear and isotropic state of a folder, each as {path: Network}."""
    expected = "expected a folder written by scripts/biaxial.py"
    if not folder.is_dir():
        raise ValueError(f"{folder} is not a folder; {expected}")
    paths = sorted(folder.glob("network-*.h5"))
    if not paths:
        raise ValueError(f"{folder} has no network-*.h5; {expected}")
    isotropic = [path for path in [folder / "isotropic.h5"] if path.exists()]
    return tuple({path: Network.load(path) for path in group} for group in (paths, isotropic))


def _strain(network):
    return float(network.attributes["strain"])


def _check_one_run(sheared, isotropic, record):
    """Raise ValueError unless all networks, by path, belong to one run."""
    networks = sheared | isotropic
    for path, network in networks.items():
        _check_network(path, network, record)
    first_path, first = next(iter(sheared.items()))
    for name, equal in dict(eta=networks, friction=sheared).items():
        try:
            common_value(equal.values(), name)
        except ValueError as error:
            raise ValueError(f"{first_path.parent}: {error}: {_TWO_RUNS}") from None
    for path, network in networks.items():
        pairs = ((network.particles[name], first.particles[name]) for name in ("id", "R", "mass"))
        if not all(np.array_equal(*pair) for pair in pairs):
            raise ValueError(f"{path} and {first_path.name} hold different grains: {_TWO_RUNS}")
    paths = {}  # by strain
    for path, network in sheared.items():
        other = paths.setdefault(_strain(network), path)
        if other != path:
            raise ValueError(f"{path} and {other.name} have the same strain: {_TWO_RUNS}")


def _check_network(path, network, record):
    """Raise ValueError if a network lacks an attribute or contradicts run.json."""
    attributes = network.attributes
    for name in ("strain", "eta", "friction", "volume"):
        if name not in attributes:
            raise ValueError(f"{path} is a network without the attribute {name}; expected strain, "
                             "eta, friction and volume, as scripts/biaxial.py stores them")
    if not network.between_particles.any():
        raise ValueError(f"{path} has no contact between grains; expected a packing that bears a "
                         "load: remove the file, or save the network after a step")
    shape = checks.choice(f"{path}: shape", attributes.get("shape", "rcr"), tuple(SHAPES))
    found = (network.particles["half_length"] / network.particles["R"]).max(initial=0)
    if shape != "trimer" and abs(found - attributes["eta"]) > 1e-6:
        raise ValueError(f"{path} has eta = {attributes['eta']:g} and grains with half_length/R up "
                         f"to {found:g}; expected equal numbers: correct the attribute")
    if not record:
        return
    known, where = record["parameters"] | dict(run=record["run"]), path.parent / run_folder.RUN
    for name in ("eta", "seed", "run", "shape", "rolling_friction"):
        given = attributes.get(name, record["run"] if name == "run" else None)
        if name in known and given != known[name]:
            raise ValueError(f"{path} has {name} = {given}, {where} {known[name]}: {_TWO_RUNS}")


def _history(path):
    """Return columns of history.csv, None if there is no such file."""
    if not path.exists():
        return None
    with files.reading(path, "a history"):
        rows = files.read_table(path, _HISTORY)
        if not rows:
            raise ValueError("holds no record; scripts/biaxial.py --resume writes it again")
        history = {name: np.array([_value(line, name, row) for line, row in enumerate(rows, 2)])
                   for name in (*_HISTORY, _YIELDED) if name in rows[0]}
        rises = np.append(True, np.diff(history["strain"]) > 0)
        checks.require(rises, "the strain", history["strain"], "more than in the record before")
        pressure = history["stress_x"] + history["stress_y"]
        checks.require(pressure > 0, "stress_x + stress_y", pressure, "> 0, compression positive")
        return history


def _value(line, name, row):
    """Return a number of history.csv."""
    try:
        value = float(row[name])
    except (TypeError, ValueError):
        raise ValueError(f"line {line}: {name} = {row[name]!r}; expected a number") from None
    return checks.number(f"line {line}: {name}", value)


def by_kind(runs, compares=False):
    """Return {`Kind`: its runs}, rising; runs of one kind are seeds.

    A ValueError reports runs that differ in friction, a run that is given twice, runs of one
    kind that differ in more than their seed, and kinds with different parameters or windows of
    strain. Unless `compares` is set, kinds that differ in more than the elongation are one more.
    """
    common_value([network for run in runs for network in run.networks], "friction")
    groups = group_by_kind(runs)
    families = {kind[:2]: kind.name for kind in groups}
    if len(families) > 1 and not compares:
        raise ValueError(f"the tests have grains of several kinds: {', '.join(families.values())}; "
                         "expected one shape and one rolling friction, or a --paper that compares "
                         "shapes: cegeo_2012 or estrada_2011")
    for group in groups.values():
        _check_seeds(group)
    for one, two in itertools.combinations(runs, 2):
        length = min(run.to_strain - run.from_strain for run in (one, two))
        _check_windows(one, two, max(2 * HALF_RECORD, _WINDOW_SHARE * length))
        todo = "tests that differ in elongation, seed and size alone; analyse others apart"
        _check_parameters(one, two, _FREE_OF_KIND, todo)
    return groups


def _check_seeds(runs):
    """Raise ValueError unless the runs have different packings and else the same parameters."""
    for one, two in itertools.combinations(runs, 2):
        if os.path.realpath(one.folder) == os.path.realpath(two.folder):
            raise ValueError(f"{two.folder} is given twice; expected every run once")
        positions = [[n.particles["position"] for n in run.networks] for run in (one, two)]
        if any(itertools.starmap(np.array_equal, itertools.product(*positions))):
            raise ValueError(f"{two.folder} and {one.folder} hold networks of the same packing; "
                             "expected packings of different seeds: leave one out")
        _check_windows(one, two, 2 * HALF_RECORD)
        if one.record and two.record and one.record["run"] == two.record["run"]:
            raise ValueError(f"{two.folder} and {one.folder} hold the same run; "
                             "expected runs of different seeds")
        _check_parameters(one, two, _FREE, "runs that differ in their seed alone")


def _check_windows(one, two, tolerance):
    """Raise ValueError if the averages of two runs are over different strains."""
    windows = [(run.from_strain, run.to_strain) for run in (one, two)]
    if not all(math.isclose(*ends, rel_tol=0, abs_tol=tolerance) for ends in zip(*windows)):
        ranges = " and ".join(f"{low:g} to {high:g}" for low, high in windows)
        raise ValueError(f"{one.folder} and {two.folder} have averages over strains of {ranges}; "
                         "give both --from-strain and --to-strain")


def _check_parameters(one, two, free, expected):
    """Raise ValueError if run.json of two runs differ in a parameter that is not free."""
    if not (one.record and two.record):
        return
    different = run_folder.differing(one.record["parameters"], two.record["parameters"], free)
    if different:
        given = f"{one.folder} has {different.replace('(here ', f'({two.folder} ')}"
        raise ValueError(f"{given}; expected {expected}")

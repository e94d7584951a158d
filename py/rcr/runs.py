"""What `scripts/biaxial.py` wrote: its networks of the critical state, its history, its isotropic state. Needs NumPy and h5py."""

import dataclasses
import pathlib

import numpy as np

from rcr.network import Network


@dataclasses.dataclass
class Run:
    """One biaxial test.

    Attributes
    ----------
    folder : pathlib.Path
    networks : list of Network
        Snapshots of the critical state, by strain.
    from_strain : float
        Where that state is taken to start [-].
    isotropic : Network or None
        End of the compaction.
    history : dict of arrays, or None
        ``strain`` [-], ``stress_x`` and ``stress_y`` on the walls [Pa], one value every record of the shear.
    """

    folder: pathlib.Path
    networks: list
    from_strain: float
    isotropic: object = None
    history: object = None

    @property
    def eta(self):
        return float(self.networks[0].attributes["eta"])

    @classmethod
    def read(cls, folder, from_strain=None):
        """The run in a folder; the critical state starts at `from_strain`, by default half of the largest strain saved.

        Raises
        ------
        ValueError
            If the folder has no network, none in the critical state, or networks of several elongations.
        """
        folder = pathlib.Path(folder)
        networks = [Network.load(path) for path in folder.glob("network-*.h5")]
        if not networks:
            raise ValueError(f"{folder} has no network-*.h5; wanted a folder written by scripts/biaxial.py")
        for name in ("strain", "eta", "friction"):
            if any(name not in network.attributes for network in networks):
                raise ValueError(f"{folder} has a network without the attribute {name}; wanted networks as scripts/biaxial.py writes them")
        networks.sort(key=_strain)
        if from_strain is None:
            from_strain = 0.5 * _strain(networks[-1])
        critical = [network for network in networks if _strain(network) >= from_strain]
        if not critical:
            raise ValueError(f"{folder} has no network at a strain ≥ {from_strain:g}; its last is at {_strain(networks[-1]):.4f}")
        isotropic = folder / "isotropic.h5"
        return cls(folder, critical, from_strain, Network.load(isotropic) if isotropic.exists() else None, _history(folder / "history.csv"))

    def critical_stresses(self):
        """σ₂ and σ₁ of the records in the critical state, (rows, 2) [Pa]: σ_x and σ_y of the walls, or those of the networks without a history."""
        if self.history is not None:
            late = self.history["strain"] >= self.from_strain
            if late.any():
                return np.column_stack([self.history["stress_x"], self.history["stress_y"]])[late]
        return np.array([network.principal_stresses() for network in self.networks])


def _strain(network):
    return float(network.attributes["strain"])


def _history(path):
    """Columns of history.csv, None if there is no such file."""
    if not path.exists():
        return None
    rows = np.atleast_1d(np.genfromtxt(path, delimiter=",", names=True))
    columns = ("strain", "stress_x", "stress_y")
    missing = set(columns) - set(rows.dtype.names or ())
    if missing:
        raise ValueError(f"{path} lacks the column {' and '.join(sorted(missing))}")
    return {name: rows[name] for name in columns}


def by_elongation(runs):
    """{η: its runs}, η rising: runs of the same elongation are seeds.

    Raises
    ------
    ValueError
        If the runs differ in friction.
    """
    frictions = sorted({float(network.attributes["friction"]) for run in runs for network in run.networks})
    if len(frictions) > 1:
        raise ValueError(f"the networks have friction {', '.join(f'{v:g}' for v in frictions)}; wanted one friction for all")
    return {eta: [run for run in runs if run.eta == eta] for eta in sorted({run.eta for run in runs})}

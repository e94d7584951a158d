"""What a biaxial test has left, without what an interruption may change."""

import json
import pathlib

from rcr.network import Network

CLOCK = {"wall_seconds"}  # of the summary


def contents(folder):
    """{name: value} of the history, every network and the summary of a run that is complete, to be compared by ==."""
    folder = pathlib.Path(folder)
    found = {"history.csv": (folder / "history.csv").read_text()}
    for path in sorted(folder.glob("*.h5")):
        network = Network.load(path)
        found[path.name] = {name: column.tolist() for group in (network.particles, network.contacts) for name, column in group.items()}
        found[path.name]["attributes"] = network.attributes
    summary = json.loads((folder / "summary.json").read_text())
    return found | {"summary.json": {name: value for name, value in summary.items() if name not in CLOCK}}


def different(one, other):
    """Names of what differs between two contents."""
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))

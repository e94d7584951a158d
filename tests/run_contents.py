"""Results of a biaxial test, without what an interruption changes."""

import json
import pathlib
import subprocess
import sys
import time

from rcr.network import Network

COST = {"wall_seconds", "peak_memory_bytes"}  # keys of the summary that differ between equal runs


def contents(folder):
    """{name: value} of history, networks and summary of a complete run, comparable by ==."""
    folder = pathlib.Path(folder)
    found = {"history.csv": (folder / "history.csv").read_text()}
    for path in sorted(folder.glob("*.h5")):
        network = Network.load(path)
        found[path.name] = {name: column.tolist() for group in (network.particles, network.contacts)
                            for name, column in group.items()}
        found[path.name]["attributes"] = network.attributes
    summary = json.loads((folder / "summary.json").read_text())
    return found | {"summary.json": {name: value for name, value in summary.items()
                                     if name not in COST}}


def campaign_contents(out):
    """{name: value} of all runs of a campaign and its analysis."""
    out = pathlib.Path(out)
    found = {f"{run.name}/{name}": value for run in sorted((out / "runs").iterdir())
             for name, value in contents(run).items()}
    return found | {"analysis.json": json.loads((out / "report" / "analysis.json").read_text())}


def different(one, other):
    return sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))


def start_until_written(path, command, **settings):
    """Start a process; returns it once it has ended or has written this file."""
    written = lambda: path.stat().st_mtime_ns if path.exists() else 0
    before, process = written(), subprocess.Popen(command, **settings)
    while process.poll() is None and written() == before:
        time.sleep(0.01)
    return process


if __name__ == "__main__":  # run_contents.py CAMPAIGN CAMPAIGN
    one, other = map(campaign_contents, sys.argv[1:])
    names = different(one, other)
    print(f"{len(names)} of {len(one)} differ: {', '.join(names)}" if names
          else f"{len(one)} results in {len({name.split('/')[0] for name in one}) - 1} runs are "
          f"equal")
    sys.exit(bool(names))

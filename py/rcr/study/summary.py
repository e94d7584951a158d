"""Contents of `summary.json` of a biaxial test. Needs YADE."""

import pathlib
import re

import numpy as np
from yade.wrapper import Omega

import rcr
from rcr.network import CAP_CAP, CAP_SIDE, SIDE_SIDE, sin_phi
from rcr.study.protocol import PROTOCOL, critical_start, is_critical

O = Omega()


def summarize(test, include_yielded=False):
    """Return the contents of `summary.json` of a `Biaxial`, {key: value}.

    Means are those of the records in the second half of the strain. Records with a step without a
    solution are left out, unless `include_yielded` is set. Contacts and overlaps are those of the
    last record; `last_record_left_out` says that the means leave it out. docs/study/biaxial.md
    describes the keys.
    """
    names = "eta", "particles", "seed", "shape", "sides", "size_span", "rolling_friction"
    parameters = {name: test.parameters[name] for name in names}
    means = _strength(test, include_yielded)
    left_out = bool(test.rows) and test.rows[-1]["yielded_steps"] > 0 and not include_yielded
    last = dict(last_record_left_out=left_out)
    return parameters | means | last | _structure(test) | _geometry(test) | _work(test)


def _strength(test, include_yielded):
    """Return the strain and the means of the wall stresses."""
    start = critical_start(test.strain)
    late = [row for row in test.rows if is_critical(row["strain"], start)]
    used = [row for row in late if include_yielded or row["yielded_steps"] == 0]
    found = dict(strain=test.strain, sin_phi=None, sin_phi_std=None, stress_x_std=None)
    if used:
        x, y, ratio = np.transpose([[row[k] for k in ("stress_x", "stress_y", "sin_phi")]
                                    for row in used])
        found |= dict(sin_phi=float(sin_phi([x.mean(), y.mean()])), sin_phi_std=float(ratio.std()),
                      stress_x_std=float(x.std() / PROTOCOL.confining_stress))
    return found | dict(
        records=len(late), records_left_out=len(late) - len(used), include_yielded=include_yielded)


def _structure(test):
    """Return observables of the last contact network."""
    network = test.network()
    types = network.contacts["type"][network.between_particles]
    force = network.local_components()[3][:, 0]
    overlaps = test.overlaps()
    frictional = network.attributes["friction"] > 0
    mobilization = float(network.friction_mobilization().mean()) if frictional else 0.0
    return dict(
        packing_fraction_initial=test.progress["packing_fraction_initial"],
        packing_fraction_final=test.packing_fraction, coordination_number=network.coordination(),
        fraction_cc=float(np.mean(types == CAP_CAP)), fraction_cs=float(np.mean(types == CAP_SIDE)),
        fraction_ss=float(np.mean(types == SIDE_SIDE)), friction_mobilization=mobilization,
        weak_fraction=float(np.mean(force < force.mean())), mean_overlap=float(overlaps.mean()),
        max_overlap=float(overlaps.max(initial=0)))


def _geometry(test):
    """Return the rate, the shape of the box, and the state after the compaction."""
    parameters, progress = test.parameters, test.progress
    first_height = progress["first_height"]
    first_width = test.area / (progress["packing_fraction_initial"] * first_height)
    along_width, along_height = test.sample_inertia()
    return dict(
        inertial_number=_mean_rate(test), approach=parameters["approach"],
        inertial_number_final=progress["rate"],
        aspect_ratio_initial=first_width / first_height, aspect_ratio=test.width / test.height,
        sample_inertia=along_width, sample_inertia_height=along_height,
        unbalance_initial=progress["unbalance_initial"],
        stress_deviation_initial=progress["stress_deviation_initial"])


def _mean_rate(test):
    """Return the mean I of the records in the means, None without two records.

    It is the change of the strain over that of the time, in units of t₀.
    """
    start = critical_start(test.strain)
    first = next((k for k, row in enumerate(test.rows) if is_critical(row["strain"], start)), None)
    if first is None or len(test.rows) < 2:
        return None
    one, last = test.rows[max(first - 1, 0)], test.rows[-1]  # a record begins at the one before
    return (last["strain"] - one["strain"]) / (last["time"] - one["time"]) * test.time_unit


def _work(test):
    """Return the steps, the errors of the solver, and the cost."""
    progress = test.progress
    missed, yielded = progress["missed"], progress["yielded"]
    return dict(
        steps=O.iter, dt=O.dt, iterations_mean=progress["iterations"] / O.iter,
        residual_max=progress["residual_max"], unconverged_steps=max(0, missed - yielded),
        yielded_steps=yielded, repeated_parts=progress["repeated"],
        missed_fraction=missed / max(1, O.iter - progress["first_step"]),
        missed_mean=progress["missed_sum"] / max(1, missed), missed_max=progress["missed_max"],
        tolerance=test.parameters["tolerance"], run=test.run, wall_seconds=test.wall_seconds,
        peak_memory_bytes=memory("VmHWM"),
        threads=test.solver.threads or O.numThreads, version=rcr.__version__)


def memory(name):
    """Return the memory of this process [B]: VmRSS at present, VmHWM at most.

    `getrusage` would include the peak of its parent.
    """
    status = pathlib.Path("/proc/self/status").read_text()
    return 1024 * int(re.search(rf"{name}:\s*(\d+) kB", status)[1])

"""Results of a scene print as Python numbers, not as np.float64(…)."""

import numpy as np
import rcr
from rcr import measure
from rcr.frame import Frame
from rcr.study.biaxial import Biaxial
from common import numpy_scalars, public_results
from scenes import heap, resting, steps
from yade import O
from yade.wrapper import ContactDynamics


def engine():
    return next(e for e in O.engines if isinstance(e, ContactDynamics))


def test_results_of_a_scene():
    heap()
    O.trackEnergy = True
    engine().observe, engine().observeEvery = [0, 5], 100
    steps(300)
    frame, network = Frame.of(), rcr.contact_network(volume=1, count=np.int64(3))
    assert numpy_scalars(frame) == numpy_scalars(network) == []
    assert numpy_scalars([rcr.info(), dict(O.energy.items()), engine().dict()]) == []
    observed = engine().observations()
    assert len(observed) == 3 and numpy_scalars(observed) == []
    calls = measure.extent, measure.areas, measure.porosity, measure.stress_tensors
    assert numpy_scalars([call() for call in calls]) == []
    without = "of", "of_scene", "rows", "wrap", "per_grain", "shifts"
    assert numpy_scalars(public_results(frame, without)) == []


def test_results_of_springs():
    resting("smooth")
    assert type(rcr.critical_time_step()) is float


def test_results_of_a_biaxial_test():
    test = Biaxial.prepare(0.5, 60, seed=2)
    test.compact()
    test.shear_record()
    assert len(test.rows) == 1 and numpy_scalars(test) == []
    values = "width", "height", "strain", "packing_fraction", "unbalance", "wall_seconds", "run"
    calls = "sample_inertia", "wall_stresses", "network", "summary"
    assert numpy_scalars([getattr(test, name) for name in values]) == []
    assert numpy_scalars({name: getattr(test, name)() for name in calls}) == []

"""Results print as Python numbers, not as np.float64(…)."""

import numpy as np
import pytest
import rcr
from rcr import measure, papers, problems
from rcr._data.plain import plain
from rcr.ensemble import Ensemble
from rcr.force_network.analysis import NetworkSet, measures
from rcr.network import Network, sin_phi
from rcr.observables import registry
from rcr.outlines import Outline
from rcr.study import analysis
from rcr.study.runs import Run
from rcr.xi_networks import Anisotropies

from common import numpy_scalars, public_results
from problem_files import write
from synthetic import packing, write_run

FILES = ("load", "save", "plot", "compute")  # methods that return no numbers


@pytest.fixture(scope="module")
def network():
    made = packing(0.5)
    more = dict(width=np.float64(3), count=np.int64(4), sizes=np.ones(2))
    return Network(made.particles, made.contacts, made.attributes | more)


def test_plain_converts_what_the_search_finds():
    """Numbers within dicts and tuples, also named ones; arrays and texts stay."""
    array = np.array([1.0, 2.0])
    given = dict(a=np.float64(1), b=(np.int64(2), "text"), c=np.array(3.0), d=np.bool_(True),
                 e=array, f=Anisotropies(*array, *array, np.float32(0.5)), g=np.str_("text"))
    found = [text.split(" = ")[0] for text in numpy_scalars(given)]
    assert found == [".a", ".b.0", ".c", ".d", *(f".f.{name}" for name in given["f"]._fields), ".g"]
    made = plain(given)
    assert numpy_scalars(made) == numpy_scalars(dict(g=given["g"]))
    assert made["a"] == 1 and made["b"] == (2, "text") and made["d"] is True
    assert made["e"] is array and made["f"] == given["f"] and type(made["f"]) is Anisotropies
    assert "np." in repr(given["f"]) or np.lib.NumpyVersion(np.__version__) < "2.0.0"
    assert "np." not in repr(made["f"])


def test_results_of_a_network(network):
    count = len(network.contacts["body1"])
    results = public_results(network, ("shifts", *FILES), rows=[[0]], wrap=[np.zeros((1, 2))],
                             per_grain=[np.ones(count)])  # shifts need a periodic cell
    assert len(results) > 40 and numpy_scalars(results) == []
    assert numpy_scalars(network) == numpy_scalars(Ensemble([network])) == []
    assert numpy_scalars(public_results(network.xi_networks())) == []
    once, parts = np.float64(0.5), network.xi_networks()
    assert numpy_scalars([network.weak_share(once), network.anisotropies(once), sin_phi((1, 2)),
                          network.shear_stress_ratio(once), parts.count(once)]) == []
    assert network.weak_share([0.5, 1]).shape == (2,)


@pytest.mark.parametrize("any_scene", [False, True])
def test_results_of_pooled_networks(network, any_scene):
    pooled = Ensemble([network, network], any_scene)
    assert numpy_scalars(pooled) == numpy_scalars(public_results(pooled)) == []
    found = measures(NetworkSet("two", ["a", "b"], [network, network]))
    assert numpy_scalars(found) == [] and type(found["normal_force"]["alpha"]) is float


def test_results_of_measures_and_profiles(network):
    calls = measure.extent, measure.areas, measure.porosity, measure.stress_tensors
    assert numpy_scalars([call(what=network) for call in calls]) == []
    profile = rcr.Profile(cells=(2, 3)).compute(network)
    assert numpy_scalars(public_results(profile, FILES)) == []


def test_results_of_outlines():
    square = Outline(np.array([[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]), 0.2)
    assert numpy_scalars(public_results(square, points=[4])) == []


@pytest.mark.parametrize("name", ["step.npz", "columns.h5", "blocks.dat"])
def test_results_of_problems(step, tmp_path, name):
    problem = problems.load(write(tmp_path / name, step))
    found = rcr.solve(problem)
    assert numpy_scalars(problem) == numpy_scalars(found) == numpy_scalars(found.scalars()) == []


def test_results_of_a_study(tmp_path):
    runs = [Run.read(write_run(tmp_path / f"{eta}", eta)) for eta in (0.0, 0.5)]
    results = public_results(runs[0], ("read",), is_critical=[0.2])
    assert numpy_scalars(results) == []
    ensembles = [Ensemble(run.networks) for run in runs]
    grids = registry.Grids.of(ensembles, 0.4)
    found = registry.measures(ensembles[1], grids, analysis.samples(runs[1:]))
    assert numpy_scalars(found) == [] and "O3" in found
    result = analysis.analyse(runs)
    assert numpy_scalars(result) == numpy_scalars(papers.load().findings(result)) == []

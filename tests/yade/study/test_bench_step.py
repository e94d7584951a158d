"""bench_step.py with YADE: it resumes a checkpoint and tabulates the engines' work."""

from functools import partial

import forked
import pytest
from rcr._data.files import read_table
from rcr.study.biaxial import Biaxial

bench = partial(forked.yade_script, "bench_step.py")
ENGINES = ["ForceResetter", "InsertionSortCollider", "InteractionLoop", "WallStress", "WallStress",
           "ContactDynamics", "NewtonIntegrator"]


def test_checkpoint(tmp_path):
    test = Biaxial.prepare(eta=0.5, particles=20)
    test.solver.overdamped = False
    (tmp_path / "scene").mkdir()
    test.save(tmp_path / "scene")
    bench(tmp_path / "scene", "--steps", 7, "--threads", 2, "--out", tmp_path / "out")
    all_rows, wholes = (read_table(tmp_path / "out" / f"yade_{name}.csv", ())
                        for name in ("engines", "step"))
    assert [whole["way"] for whole in wholes] == ["engines", "arrays"]
    assert [whole["in_arrays"] for whole in wholes] == ["0", "6"]
    for whole in wholes:
        rows = [row for row in all_rows if row["way"] == whole["way"]]
        engines = [row for row in rows if ":" not in row["engine"]]
        assert [row["engine"] for row in engines] == ENGINES
        assert sum(float(row["share"]) for row in engines) == pytest.approx(1)
        parts = {row["engine"].removeprefix("ContactDynamics: "): float(row["ms"]) for row in rows
                 if row not in engines}
        assert set(parts) == {"gather", "layout", "solve", "forces", "lateContacts",
                              "biasUpdate", "correct", "arrays", "writeBack", "scatter"}
        assert sum(parts.values()) <= float(engines[ENGINES.index("ContactDynamics")]["ms"])
        assert (whole["folder"], whole["grains"], whole["eta"], whole["steps"],
                whole["threads"]) == ("scene", "20", "0.5", "7", "2")
        assert float(whole["ms_least"]) <= float(whole["ms"]) and float(whole["tolerance"]) == 1e-4
        assert sum(float(row["ms"]) for row in engines) <= float(whole["ms"])


def test_so_many_sweeps(tmp_path):
    Biaxial.prepare(eta=0.5, particles=20).save(tmp_path)
    bench(tmp_path, "--steps", 3, "--iterations", 13, "--out", tmp_path / "out")
    for whole in read_table(tmp_path / "out" / "yade_step.csv", ()):
        assert float(whole["iterations"]) == 13 and float(whole["tolerance"]) == 0

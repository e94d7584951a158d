"""Charts: tables resume, known answers are found, the stock test is the same test."""

import dataclasses
import math
import os
import shlex

import forked
import numpy as np
import pytest
from benchmarks import chart, charts
from benchmarks import true_error
from benchmarks.charts import (biaxial_cost, deterministic, estimate, known_forces, large_packings,
                               one_step, quasi_static, size)
from rcr.study.biaxial import Biaxial
from rcr.study.protocol import PROTOCOL
from rcr.study.shear import switch_to_springs
from common import answer, refused
from yade import O

OPTIONS = charts.Options(out="", quick=True, particles=50, siconos="", peers="", limit=60)


def options(folder):
    return dataclasses.replace(OPTIONS, out=str(folder))


def test_a_table_resumes_where_it_stopped(tmp_path):
    path = str(tmp_path / "t.csv")
    charts.Table(path, ["x"]).put("a/1", [dict(point="a/1", status="ok", x=x) for x in (0.5, 1.5)])
    table = charts.Table(path, ["x"])
    assert table.has("a/1") and not table.has("a/2")
    table.put("a/2", [dict(point="a/2", status="given up")])
    table.put("a/1", [dict(point="a/1", status="ok", x=2.0)])
    rows = [(row["point"], row["x"]) for row in charts.Table(path, ["x"]).rows]
    assert rows == [("a/2", ""), ("a/1", 2.0)]
    # a quick run and a full one share a file; rows of another protocol are replaced
    path, other = str(tmp_path / "quick.csv"), str(tmp_path / "other.csv")
    for settings, x in (("quick = True", 1.0), ("quick = False", 2.0)):
        table = charts.Table(path, ["x"], settings)
        assert not table.has("a/1") and table.rows == []
        table.put("a/1", [dict(point="a/1", status="ok", x=x)])
    assert [row["x"] for row in charts.Table(path, ["x"], "quick = True").rows] == [1.0]
    assert charts.settings("c", OPTIONS).startswith("quick = True, particles = 50, protocol = ")
    full = dataclasses.replace(OPTIONS, quick=False)
    assert charts.settings("a", OPTIONS) != charts.settings("a", full)
    for protocol in "", ", protocol = a", ", protocol = b":
        table = charts.Table(other, ["x"], "quick = True" + protocol)
        assert not table.rows
        table.put("a/1", [dict(point="a/1", status="ok", x=1.0)])
    assert len(charts.Table(other, ["x"]).all) == 1


@pytest.mark.parametrize("content", ["", "x\n1\n", "point,status\na\n", 'point,status\n"a',
                                     "point,status\na,ok,1\n", b"\xff\x00"])
def test_damaged_tables_are_named(tmp_path, content):
    path = tmp_path / "t.csv"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    assert "\n" not in refused("t.csv: ", charts.Table, str(path), ["x"])


def test_a_point_of_one_step_runs(tmp_path):
    """Our solver, and another program with each number of iterations: a grain that stops."""
    rows = one_step.run("250/0/auto", options(tmp_path))
    assert {row["start"] for row in rows} == {"cold", "warm"}
    assert all(row["library"] == "auto" and row["seconds"] > 0 for row in rows)
    assert min(row["residual"] for row in rows) < 1e-4
    assert all(0 <= row["velocities"] < 1.5 for row in rows if "velocities" in row)
    (spread,) = one_step.run("250/0/spread", options(tmp_path))
    stops = one_step.run("250/0/default", options(tmp_path))
    assert [row["start"] for row in stops] == ["cold", "warm"] and spread["velocities"] > 0
    found = [dict(row, status="ok") for row in (*rows, spread, *stops)]
    assert one_step.plot(found, OPTIONS).axes
    for table in one_step.ratios, one_step.residuals, one_step.default_steps:
        header, *lines = table(found)
        assert lines and all(len(line) == len(header) for line in lines)
    count = 250
    before, after = np.zeros((count + 4, 3)), np.zeros((count + 4, 3))
    before[0, 1] = -1
    contact = [count + 1, 0, 0, 1, 0.5, 0, 0, -0.5, 0.0, 1.0, 0.0, -0.003]
    answer(tmp_path / "chipmunk_step", library="Other 1", seconds=[1e-3] * 20, contacts=[contact],
           before=before.tolist(), after=after.tolist())
    rows = one_step.run("250/0/chipmunk", dataclasses.replace(options(tmp_path),
                                                              peers=str(tmp_path)))
    assert {row["library"] for row in rows} == {"Other 1"}
    assert sorted({row["iterations"] for row in rows}) == [10, 40, 160]


def test_cost_over_the_number_of_grains():
    rows = [dict(row, status="ok") for name in size.points(OPTIONS)
            for row in size.run(name, OPTIONS)]
    for row in rows:
        assert 1.5 < row["points"] / row["particles"] < 3, "deposited discs touch two others each"
        assert row["seconds"] > 0 and row["sweeps"] > 1
    header, *lines = size.ratios(rows)
    assert [line[:2] for line in lines] == [["auto", "100"], ["auto", "1000"], ["nlgs", "100"],
                                            ["nlgs", "1000"]]
    assert all(len(line) == len(header) for line in lines)
    assert len(size.plot(rows, OPTIONS).axes) == 4


def test_sweeps_to_a_true_error(monkeypatch):
    """`nlgs` needs more sweeps the more grains there are; a bound of sweeps leaves no result."""
    rows = [dict(row, status="ok") for count in (100, 1000)
            for row in size.run(f"{count}/true-error", OPTIONS)]
    of = {(row["friction"] > 0, row["method"], row["particles"]): row for row in rows}
    assert all(row["reference"] < 1e-8 and row["spread"] < 1e-6 for row in rows)
    for rough in (True, False):
        assert of[rough, "nlgs", 1000]["sweeps"] > 2 * of[rough, "nlgs", 100]["sweeps"]
    assert of[True, "nesterov", 1000]["sweeps"] < of[True, "nlgs", 1000]["sweeps"] / 2
    header, *lines = size.true_errors(rows)
    assert [line[:2] for line in lines] == [["0.5", "100"], ["0.5", "1000"], ["0", "100"],
                                            ["0", "1000"]]
    assert all(len(line) == len(header) for line in lines)
    monkeypatch.setattr(size, "SEARCHED", 20)
    unreached = size.run("1000/true-error", OPTIONS)
    assert "sweeps" not in unreached[0] and "sweeps" in unreached[4], "nlgs with friction, without"
    filled = [dict(sweeps="", seconds="", status="ok") | row for row in unreached]  # as from a file
    assert list(size.true_errors(filled))[1][4] == ""
    assert size.plot(filled, OPTIONS).axes


def one_step_row(library, seconds, error, start="cold"):
    return dict(library=library, particles=500, eta=0.0, start=start, seconds=seconds,
                velocities=error, forces=error and error / 2, residual=0.1)


def test_times_to_true_errors_count_above_the_spread_only():
    """auto needs 1 s to 0.25 and 2 s to 0.05, nlgs 3 s and 8 s; solutions differ by 0.2."""
    rows = [one_step_row("auto", 1.0, 0.25), one_step_row("auto", 2.0, 0.05),
            one_step_row("nlgs", 3.0, 0.25), one_step_row("nlgs", 8.0, 0.05),
            one_step_row("nlgs", 0.5, ""),  # without a reference solution
            one_step_row(one_step.SPREAD, "", 0.2)]
    by_error = {line[0]: line[1] for line in list(one_step.ratios(rows))[1:]}
    assert by_error["0.3"] == "3 – 3 (1)" and by_error["0.1"] == by_error["0.03"] == ""
    rows[-1]["velocities"] = rows[-1]["forces"] = 1e-9  # one solution
    assert {line[0]: line[1] for line in one_step.ratios(rows)}["0.1"] == "4 – 4 (1)"


def test_where_methods_fail():
    """Of 100 bodies, Gauss–Seidel misses the answer and says so; auto finds it."""
    for scene in known_forces.SCENES:
        (right,), (wrong,) = (known_forces.run(f"{scene}/100/{method}", OPTIONS)
                              for method in ("auto", "nlgs"))
        assert right["error"] < 0.01 and right["converged"], scene
        assert wrong["error"] > 0.3 and not wrong["converged"], scene
        header, *lines = known_forces.ratios([right, wrong])
        assert [scene in line[0] for line in lines] and all(len(line) == 3 for line in lines)
    assert len(known_forces.plot([dict(right, status="ok")], OPTIONS).axes) == 10


def test_errors_of_a_packing_fall_with_the_sweeps(tmp_path, monkeypatch):
    monkeypatch.setitem(true_error.REFERENCE, "max_iterations", 50_000)
    rows = large_packings.run("60/0.7", options(tmp_path))
    for start in "warm", "cold":
        first, *_, last = (row for row in rows if row["method"] == "nesterov"
                           and row["start"] == start)
        assert last["forces"] < 0.5 * first["forces"]  # which are not unique
        assert all(last[name] < 1e-3 * first[name]
                   for name in ("velocities", "cells_8", "cells_2"))
    header, *lines = large_packings.ratios(rows)
    assert len(lines) == len(rows) and all(len(line) == len(header) for line in lines)
    assert len(large_packings.plot([dict(row, status="ok") for row in rows], OPTIONS).axes) == 1


def test_estimates_of_a_column_and_their_table():
    """Impulses of the column are known, so its true errors are their errors."""
    rows = estimate.run("column/10/0/1", OPTIONS)
    assert {row["start"] for row in rows} == {"cold", "warm"}
    assert {row["stop"] for row in rows} == {*estimate.SWEEPS, "auto"}
    column = estimate._first_step("column", 10)
    heights = np.argsort(np.argsort(column["bodies"].max(1)))  # of the points, upwards
    mass = 1 / column["inverse_mass"][:, 0].max()
    exact = mass * 9.81e-3 * np.column_stack([10 - heights, 0 * heights])
    assert true_error.solution(column, 0 * exact) == pytest.approx(exact, abs=1e-6)
    error = lambda estimated, true: dict(scene="row", stop=20.0, estimate=estimated,
                                         velocities=true, forces=true / 2)
    rows = [error(0.1, 0.1), error(0.25, 0.1), error(0.35, 0.1), error(0.009, 0.1), error(2, 0.1),
            error(1, 1e-4)]  # the last one is too small to count
    _, (*_, number, close, below, above, median, of_small, met) = estimate.ratios(rows)
    assert (number, close, below, above) == ("5", "40.0 %", "20.0 %", "20.0 %")
    assert (median, of_small, met) == ("2.5", "50.0 % (4)", "no")


def error(name):
    (row,) = deterministic.run(name, OPTIONS)
    return row["value"] / row["reference"] - 1, row["steps"]


@pytest.mark.parametrize("scene", ["incline", "disc"])
def test_rigid_error_is_that_of_the_leapfrog(scene):
    """x = a dt² n (n + 1)/2 is a t²/2 (1 + dt/t); half_step_start makes it exact."""
    found, steps = error(f"{scene}/cd/0.005/1e-08")
    assert found == pytest.approx(0.005 / 0.5, abs=1e-5) and steps == 100
    half, whole = (abs(error(f"{scene}/{way}/0.02/1e-08")[0]) for way in ("half", "cd"))
    assert half < 1e-6 < 0.03 < whole


def test_errors_fall_with_dt_and_stiffness():
    """To first order; with half_step_start nearly to second order, 400 for dt/20."""
    size = lambda point: abs(error(f"ladder/{point}")[0])
    assert size("cd/0.0025/1e-08") == pytest.approx(size("cd/0.005/1e-08") / 2, rel=0.1)
    assert size("smooth/10000") < 0.1 * size("smooth/100")
    coarse = size("half/0.02/1e-08")
    assert size("half/0.001/1e-08") < coarse / 80 and coarse < 0.1 * size("cd/0.02/1e-08")


@pytest.mark.parametrize("eta", [0.0, 0.5])
def test_all_laws_shear_the_same_packing(eta, tmp_path):
    """Mass, walls and stress are the same; the network of clumps carries the walls' forces."""
    compacted = lambda: biaxial_cost.compacted(eta, 1, options(tmp_path))
    rigid = compacted()
    fraction, masses = rigid.packing_fraction, [O.bodies[i].state.mass for i in rigid.grains]
    smooth = compacted()
    switch_to_springs(smooth, 1e3)
    assert smooth.packing_fraction == fraction and smooth.parameters["law"] == "smooth"
    smooth.shear_record()  # after it has unloaded its springs
    assert smooth.mean_stresses[0] == pytest.approx(PROTOCOL.confining_stress, rel=0.3)

    stock = biaxial_cost.Stock(compacted(), 1e3)
    assert stock.packing_fraction == pytest.approx(fraction)
    assert [O.bodies[i].state.mass for i in stock.grains] == masses
    spheres = sum(hasattr(b.shape, "radius") for b in O.bodies)
    assert spheres == 50 * (1 if eta == 0 else 1 + math.ceil(4 * eta / (1 - eta)))
    for _ in range(20):
        stock.shear_record()
    network = stock.network()  # of one step; walls give averages
    assert np.diag(network.stress()) == pytest.approx(stock.mean_stresses, rel=0.15)
    assert 0 < network.friction_mobilization().mean() <= 1


def test_true_errors_of_a_step_of_the_biaxial_test(tmp_path):
    """Solved again, the step has its residual; a smaller accuracy lowers its true error."""
    test = biaxial_cost.compacted(0.5, 1, options(tmp_path))
    found = {}
    for accuracy in math.inf, 1e-4:
        test.solver.accuracy = accuracy
        for _ in range(3):
            test.shear_record()
        found[accuracy] = biaxial_cost._errors_of_last_step(test)
        assert set(found[accuracy]) == {*biaxial_cost.TRUE, *biaxial_cost.SPREADS}
    assert found[1e-4]["velocities"] < 0.1 * found[math.inf]["velocities"]
    rows = [dict(biaxial_cost.DEFAULT, law="cd", eta=0.5, seconds=1.0, **found[1e-4])]
    lines = [line for line in biaxial_cost.true_errors(rows) if line[0] == "0.5"]
    assert sum("unknown" not in line for line in lines) == len(biaxial_cost.SWEEPS)


@pytest.mark.parametrize("law, most", [("cd", 1e-12), ("smooth", 1e-3), ("stock", 0.02)])
def test_the_work_of_the_walls_is_accounted_for(law, most, tmp_path):
    """Rigid contacts to rounding for any step, springs and clumps to the error of their steps."""
    test = biaxial_cost.compacted(0.5, 1, options(tmp_path))
    if law == "smooth":
        switch_to_springs(test, 1e3)
    test = biaxial_cost.Stock(test, 1e3) if law == "stock" else test
    for _ in range(10):
        test.shear_record()
    found = biaxial_cost._energies(test)
    assert found["energy_error"] < most and 0.3 < found["friction_share"] < 1.2


@pytest.mark.slow
def test_script_runs_a_point_again(tmp_path):
    done = forked.yade_script("chart.py", "--out", tmp_path, "--quick", "--charts", "b", "--only",
                              "disc/cd/0.02/0.0001")
    assert '"scene": "disc"' in done.stdout, done.stderr
    pictures = {f"b-deterministic.{suffix}" for suffix in ("csv", "png", "svg")}
    assert set(os.listdir(tmp_path)) == {*pictures, "run.json"}
    (row,) = charts.Table(str(tmp_path / "b-deterministic.csv"), deterministic.COLUMNS).rows
    assert row["command"].endswith("--quick --charts b --only 'disc/cd/0.02/0.0001'")
    assert row["settings"] == "quick = True"


def test_points_that_ran_out_of_time_are_repeated_with_more(monkeypatch):
    """Other failures are findings; --retry repeats both. The command has all options."""
    statuses = "ok", "given up after 40 s", "given up after 60 s", "RuntimeError: flew apart"
    settled = lambda retry: [charts.settled(status, 60, retry=retry) for status in statuses]
    assert settled(retry=False) == [True, False, True, True]
    assert settled(retry=True) == [True, False, False, False]
    words = "chart.py", "--out", "my charts", "--quick", "--charts", "a", "--peers", "my peers"
    for given, expected in (words, words), (words[:-2], words[:-2]):
        monkeypatch.setattr("sys.argv", [*given])
        found = shlex.split(chart.command("a", "250/0/chipmunk", chart.arguments()[0]))
        assert found[:2] == ["python3", "scripts/chart.py"]
        assert sorted(found[2:]) == sorted([*expected[1:], "--only", "250/0/chipmunk"])


def test_slope_of_rates_is_found_in_pairs():
    """y = 0.4 + 2 √I, with another level for each seed."""
    rates = {1: (1e-3, 3e-4, 1e-4, 3e-5), 2: (1e-3, 1e-4)}
    rows = [dict(seed=seed, inertial_number=rate, y=0.4 + 0.05 * (seed - 1) + 2 * math.sqrt(rate))
            for seed in rates for rate in rates[seed]]
    slope, error = quasi_static.slope_of_rates(rows, "y")
    assert slope == pytest.approx(2, abs=1e-9) and error < 1e-9
    noisy = [dict(row, y=row["y"] + 0.01 * (-1) ** k) for k, row in enumerate(rows)]
    slope, error = quasi_static.slope_of_rates(noisy, "y")
    assert abs(slope - 2) < 3 * error and 0 < error < 2
    assert math.isnan(quasi_static.slope_of_rates(rows[:2], "y")[0])


def test_point_of_the_rate_is_the_same_in_one_go_and_interrupted(tmp_path, monkeypatch):
    """Checkpoints and an interruption give the same row; rows of different rates differ."""
    for setting, value in (("STRAIN", 0.13), ("FROM", 0.11), ("PAUSE", 0)):
        monkeypatch.setattr(quasi_static, setting, value)
    name = "0/50/1e-3/0.4/300/1e-4/1"
    (straight,) = quasi_static.run(name, options(tmp_path / "straight"))
    records = 0

    def broken(test, shear=Biaxial.shear_record):
        nonlocal records
        records += 1
        if records == 115:
            raise KeyboardInterrupt
        shear(test)

    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(Biaxial, "shear_record", broken)
        quasi_static.run(name, options(tmp_path))
    (again,) = quasi_static.run(name, options(tmp_path))
    assert again | {"seconds": 0} == straight | {"seconds": 0}
    # a record of 0.001 takes three steps of at most 4e-4; five at the mean rate 5.5e-4 of the first
    # one, which accelerates from the rate at the end of the approach
    assert again["inertial_number"] == 1e-3 and again["steps"] == 5 + 29 * 3
    assert 0 < again["packing_fraction"] < 1

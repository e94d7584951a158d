"""Draw charts of error against time and of stability, each as CSV, PNG and SVG.

a  one step: true error against time of every solver, warm and cold; Siconos, Chipmunk and Box2D if
   they are installed
b  scenes with a known answer: error against time, over dt and tolerance or over stiffness
c  biaxial test: true errors of its steps and errors of its observables against time for 20 % of
   strain
d  hard scenes: hold, drift or blow up, over dt and law
e  biaxial test: changes of the observables by rate, time step and solver; takes hours, not in the
   default
f  a column that collapses: time, sweeps and memory over the number of grains, up to 10^6; takes
   hours and 10 GB of memory, not in the default
g  estimates of the error of a solve against its true error
h  where methods fail: scenes with a known momentum or base force, over the number of bodies
i  biaxial test: changes of the observables by the error of its steps; takes hours, not in the
   default

A CSV has one row a point, with the command that repeats it. Points that it has for the same
settings are not run again, so an interrupted call resumes. A larger --limit repeats points that ran
out of time. Times are processor time of one thread.
"""

import json
import multiprocessing
import os
import shlex
import signal

os.environ["OMP_NUM_THREADS"] = "1"  # before NumPy is imported
import matplotlib
import yade  # noqa: F401
from tqdm import tqdm

matplotlib.use("Agg")
tqdm.monitor_interval = 0  # no thread, so that a fork is safe
from benchmarks import charts, tables
from rcr import script
from rcr._data import files, run_folder


def arguments():
    parser = script.Parser(prog="chart.py", description=__doc__)
    add = parser.add_argument
    add("--out", type=script.folder, required=True, metavar="DIR",
        help="folder of the charts, made if missing")
    add("--charts", nargs="+", choices=list(charts.NAMES), default=list("abcdgh"), metavar="C",
        help="some of a to j (default: all but e, f, i and j; e needs --limit 3600, f, i and j 7200)")
    add("--quick", action="store_true",
        help="smaller packings, fewer points: up to ten minutes on two cores")
    add("--only", metavar="POINT",
        help="run this point of one chart again and print its rows; the CSV has the names")
    add("--particles", type=script.at_least(50, 10**7), default=None, metavar="N",
        help="grains of the biaxial tests (default: 400, --quick 100)")
    add("--siconos", default="", metavar="PYTHON",
        help="a Python with siconos.numerics and scipy, inside or outside the environment")
    tables.add_peers(parser)
    add("--retry", action="store_true", help="run the points without numbers again")
    add("--limit", type=script.number("seconds > 0", lambda v: v > 0), default=None, metavar="S",
        help="time limit of a point [s] (default: 200, --quick 40)")
    given = parser.parse_args()
    if given.only and len(given.charts) != 1:
        parser.error(f"--only {given.only}: say which chart it is of, --charts C")
    particles = given.particles or (100 if given.quick else 400)
    limit = given.limit or (40 if given.quick else 200)
    return given, charts.Options(os.path.abspath(given.out), given.quick, particles, given.siconos,
                                 os.path.abspath(given.peers), limit)


def command(letter, point, given):
    flags = ["--quick"] if given.quick else []
    flags += [word for name in ("particles", "siconos", "peers", "limit")
              if getattr(given, name) not in (None, "", tables.PEERS)
              for word in (f"--{name}", shlex.quote(str(getattr(given, name))))]
    return " ".join(["python3 scripts/chart.py --out", shlex.quote(given.out), *flags, "--charts",
                     letter, "--only", f"'{point}'"])


# ---- the process that computes

def work(pipe, letter, point, options):
    """Send the rows of a point; YADE and libraries print nothing."""
    with open(os.devnull, "w") as nothing:
        os.dup2(nothing.fileno(), 1)
        os.dup2(nothing.fileno(), 2)
    try:
        rows = [dict(status="ok") | row for row in charts.chart(letter).run(point, options)]
    except (ValueError, RuntimeError, OSError) as error:
        rows = [dict(status=f"{type(error).__name__}: {error}".splitlines()[0][:200])]
    pipe.send(rows)


def computed(letter, point, options):
    """Rows of a point from its own process; one row with a status on a time limit or a crash."""
    pipe, end = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(
        target=work, args=(end, letter, point, options), daemon=True)
    signal.pthread_sigmask(signal.SIG_BLOCK, script.SIGNALS)  # else `start` may lose the process
    process.start()
    try:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, script.SIGNALS)
        end.close()
        if pipe.poll(options.limit):
            return pipe.recv()
        status = f"{charts.GIVEN_UP}{options.limit:g} s"
        process.kill()
    except EOFError:
        process.join()
        status = f"the process ended with code {process.exitcode}"
    except KeyboardInterrupt:
        process.kill()
        raise
    finally:
        process.join()
    return [dict(status=status)]


# ---- the script

def draw(letter, given, options):
    """Run the missing points of a chart, write its CSV and draw it."""
    module = charts.chart(letter)
    base = os.path.join(options.out, f"{letter}-{charts.NAMES[letter].replace('_', '-')}")
    table = charts.Table(base + ".csv", module.COLUMNS, charts.settings(letter, options))
    names = module.points(options)
    if given.only:
        if given.only not in names:
            raise ValueError(f"--only {given.only}: chart {letter} has no such point; "
                             f"it has {', '.join(names[:5])} … (see its CSV)")
        todo = [given.only]
    else:
        is_settled = lambda status: charts.settled(status, options.limit, given.retry)
        todo = [name for name in names if not table.has(name, is_settled)]
    for name in tqdm(todo, desc=f"chart {letter}", disable=None):
        rows = [dict(row, point=name, command=command(letter, name, given))
                for row in computed(letter, name, options)]
        table.put(name, rows)
        if given.only:
            print(json.dumps(rows, indent=2))
    figure = module.plot([row for row in table.rows if row["point"] in names], options)
    for suffix in "png", "svg":
        with files.atomic_path(f"{base}.{suffix}") as partial:
            figure.savefig(partial, dpi=110, bbox_inches="tight")
    found = [row for row in table.rows if row["status"] == "ok"]
    for name in charts.TABLES:
        if hasattr(module, name):
            print("\n".join(map(" | ".join, getattr(module, name)(found))))
    failed = len(table.rows) - len(found)
    print(f"{base}.png: {len(table.rows)} rows"
          + (f", {failed} without numbers (column status)" if failed else ""))


def main():
    given, options = arguments()
    parameters = dict(charts=given.charts, quick=options.quick, particles=options.particles,
                      siconos=options.siconos, limit=options.limit)
    with run_folder.claim_folder(options.out, "chart.py", parameters, [], free=list(parameters),
                              resume=True, wait=True) as begin:
        begin()  # several calls may fill a folder; each row has its settings
    for letter in given.charts:
        with run_folder.lock_folder(options.out, f".lock-{letter}"):
            draw(letter, given, options)

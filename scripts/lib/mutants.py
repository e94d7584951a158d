"""Mutation tests of the kernels: kernels with one error each, which a test must catch.

A mutant that compiles and passes all kernel tests has survived, and the check fails. The check also
fails if the kernels without errors do not pass. Ctrl-C ends it and prints the results so far.
"""

import shutil
import subprocess
import sys
import time
from collections import namedtuple

import check

Mutant = namedtuple("Mutant", "name file before after")

KERNEL = "pkg/kernel"
# Processor time of all tests of one mutant [s]; tests of its folder have a quarter, the clock six
# times as much. Mutants that never end exceed it.
LIMIT = 600

TABLE = {
    "geometry/shadow_overlap.cpp": [
        ("rounding-of-ends", "1 + 1e-9", "1 - 1e-9"),
        ("foot-at-the-other-end", "(s < 0 ? -a : a) * axis;", "(s < 0 ? a : -a) * axis;"),
        ("gap-with-one-radius", "f.distance - radius1 - radius2", "f.distance - radius1"),
        ("position-on-body-1", "0.5 * (surface1 + surface2)", "surface1"),
        ("second-point-of-the-back", ".side || dot(facing[k].normal, first.normal) <= 0", ".side"),
        ("nearest-second-point", "distance <= farthest)",
         "(result.count == 2 && distance >= farthest))"),
        ("crossing-on-one-line", "< 0 && gaps.across2 < 0 && gaps.along1 < 0",
         "< 0 && gaps.across2 < 0"),
        ("deepest-end", "if (-std::abs(h) <= least.", "if (k > 0 && -std::abs(h) >= least."),
        ("wall-of-one-cap", "if (s.halfLength == 0) break;\n\t}\n\tif (result.count",
         "break;\n\t}\n\tif (result.count"),
        ("shadow-slides-back", "(along > 0) == ofOne ? 1 : -1", "(along > 0) == ofOne ? -1 : 1"),
        ("shadow-always-slides", "if (first.side != second.side)", "if (true)"),
    ],
    "geometry/shadow_overlap.hpp": [
        ("distance-without-gap", "+ s2.capRadius + maxGap,", "+ s2.capRadius,"),
        ("points-not-sorted", "[0].position, axis) < 0)", "[0].position, axis) < -1e300)"),
    ],
    "geometry/polygon_overlap.cpp": [
        ("foot-within-the-side", "foot >= -reach && foot <= c.length[side] + reach",
         "foot >= reach && foot <= c.length[side] - reach"),
        ("foot-anywhere", "return foot >= -reach && foot <= c.length[side] + reach;",
         "return true || foot > reach;"),
        ("first-vertex-is-nearest", "if (h > nearest) break;", "break;"),
        ("nearest-side", "if (distance > best.distance) best =", "if (side == 0) best ="),
        ("parallel-sides-untied", "- level > face.distance + reach) continue;",
         "- level > face.distance - reach) continue;"),
        ("ends-of-the-other-side-unseen", "if (onSide(other, side, c.vertex(end))) {",
         "if (false) {"),
        ("core-2-not-turned", "std::swap(found.end2[0], found.end2[1]); // core 2", "// core 2"),
        ("corners-of-core-2-not-turned",
         "endsOfVertex(two, j, found.end2);\n\t\tstd::swap(found.end2[0], found.end2[1]);",
         "endsOfVertex(two, j, found.end2);"),
        ("normal-from-core-2", "face.ofOne ? normal : -normal;", "normal;"),
        ("steeper-side", "if (!(opening < flattest)) continue;",
         "if (result.count == 2 && opening < flattest) continue;"),
        ("second-point-beyond-the-alert", "|| end.distance - radii > maxGap) continue;",
         ") continue;"),
        ("gap-with-one-rounding", "distance - radius1 - radius2 };", "distance - radius1 };"),
        ("shadow-of-the-longer-side", "end.length   = std::min(", "end.length   = std::max("),
        ("shadow-slides-on-core-1", "end.slide = side == 1 ? sign : -sign;", "end.slide = sign;"),
        ("slope-without-direction", "end.slope = -sign *", "end.slope ="),
        ("highest-vertex-on-a-wall", "if (height(k) < height(lowest)) lowest = k;",
         "if (height(k) > height(lowest)) lowest = k;"),
    ],
    "geometry/convex_polygon.cpp": [
        ("circle-of-the-nearest-vertex", "dot(vertices[k], outward(along.back()))",
         "norm(vertices[k])"),
        ("circumscribed-of-the-last", "std::max(circumscribed, norm(vertices[k]))",
         "norm(vertices[k])"),
        ("clockwise-accepted", "if (!(sine > 1e-9 * size))",
         "if (!(std::abs(sine) > 1e-9 * size))"),
        ("corners-on-a-side", "if (!(sine > 1e-9 * size))", "if (!(sine > -1e-9 * size))"),
        ("stars-accepted", "turned < 3 * M_PI ?", "true ?"),
        ("sector-of-a-full-disc", "0.25 * angle * r * r * r * r", "0.5 * angle * r * r * r * r"),
        ("sector-without-its-lever", "+ 2 * r * r * r / 3 * dot(v[k], mean)", ""),
        ("rectangle-about-its-side", "+ 0.5 * r * n);", ");"),
        ("moment-about-the-origin", "second - area * dot(centroid, centroid)", "second"),
    ],
    "problem/coulomb.hpp": [
        ("without-de-saxce", "(u.n + friction * std::abs(u.t)) / wnn", "u.n / wnn"),
        ("sticks-beyond-the-cone", "::abs(t) <= friction * n", "::abs(t) <= 1.001 * friction * n"),
        ("slides-along-the-slip", "> 0 ? -friction : friction", "> 0 ? friction : -friction"),
        ("no-painleve", "* w.nn ? opposing : -opposing;", "* w.nn ? opposing : opposing;"),
        ("rounding-sticks", "schur > roundingShare * w.tt", "schur > 0"),
        ("rounding-responds", "if (w.nn <= negligibleLever", "if (w.nn < 0 * negligibleLever"),
        ("uncoupled-normal", "n = -(gn + w.nt * t) / w.nn", "n = -gn / w.nn"),
        ("projection-without-polar", "if (friction * t <= -p.n) return {", "if (p.n < 0) return {"),
        ("projection-off-the-cone", "(1 + friction * friction)", "(1 + friction)"),
        ("restitution-not-cut", "> 0 ? active : passive) =", "< 0 ? active : passive) ="),
    ],
    "problem/residual.hpp": [
        ("without-bias", "lawError(p, { un, u.t }", "lawError(p, { u.n, u.t }"),
        ("kinematic-error-of-impulses", "wnn * wnn * error2", "error2"),
        ("scale-overflows", "scale2 <= std::numeric_limits<double>::max()", "true"),
        ("no-scale-of-stopping", "std::max(impulse2, 1e-16 * stopping2)", "impulse2"),
    ],
    "problem/settings.hpp": [
        ("estimate-ignored", "&& errorEstimate <= accuracy;", ";"),
    ],
    "solve/solve.cpp": [
        ("islands-judged-together", "swept.islands.size() <= 1", "true"),
    ],
    "solve/stages.cpp": [
        ("keeps-positive-cost", "if (hasPositiveCost(problem, points.begin()",
         "if (false && hasPositiveCost(problem, points.begin()"),
        ("yielded-for-ever",
         "std::fill(island.problem.yielded.begin(), island.problem.yielded.end(), false);", ""),
        ("no-cold-start", "island.problem.clearImpulses();", ""),
        ("no-verdict", "{ State::solved, confirm },", "{ State::ended, confirm },"),
        ("too-fine-for-sweeps", "exactBelow     = 1e-6;", "exactBelow     = 1e-12;"),
    ],
    "solve/solve_auto.cpp": [
        ("exact-iterations-for-one-sweep", "sweepsPerExact = 20;", "sweepsPerExact = 1;"),
    ],
    "problem/contact_problem.cpp": [
        ("one-id-unchecked", ">= bodies || std::size_t(c.body2) >= bodies", ">= bodies"),
    ],
    "problem/refuse.hpp": [
        ("nan-is-finite", "((values - values) + ...) == 0", "!(((values - values) + ...) > 0)"),
    ],
    "sweep/layout/coloring.hpp": [
        ("second-body-free", "if (moves2) used_[body2] |= lowest;", ""),
        ("overflow-takes-a-colour",
         "if (lowest >> colors) return none;\n\t\tif (moves1) used_[body1] |= lowest;",
         "if (moves1) used_[body1] |= lowest;\n\t\tif (lowest >> colors) return none;"),
    ],
    "sweep/layout/layout.cpp": [
        ("model-of-the-first-point", "joins ? common(c.required, next.required) : c.", "c."),
        ("layout-kept-for-other-kinds", "&& sameBodies && samePairs", "&& samePairs"),
        ("layout-kept-for-another-cell", "&& sameCell && sameBodies &&", "&& sameBodies &&"),
        ("special-bodies-packed", "|| !packable(pair)) return none;", ") return none;"),
        ("threads-share-small-islands", "pairs > maxSerialIsland", "pairs > 0"),
        ("levers-of-one-body", "(c.body1, c.arm1) || lever(c.body2, c.arm2)", "(c.body1, c.arm1)"),
        ("light-cells-lag", "return cell < 0.5 * least;", "return true;"),
    ],
    "sweep/packed_cell.cpp": [
        ("free-fall-stretches", "moment = -1 * packed_.freeMoment_ - ", "moment = -1 * "),
    ],
    "sweep/layout/layout_blocks.cpp": [
        ("driven-bodies-share-a-record", "if (moves(body)) return offsetOf(", "return offsetOf("),
        ("empty-lanes-of-one-side", "pairBlocks_.back().body2[lane] = offsetOf(appendRecords(1));",
         "pairBlocks_.back().body2[lane] = pairBlocks_.back().body1[lane];"),
    ],
    "sweep/layout/partitions.cpp": [
        ("partitions-of-one-level", "minLevels = 2", "minLevels = 1"),
        ("neighbours-of-one-side", "add(edge[0], edge[1]), add(edge[1], edge[0]);",
         "add(edge[0], edge[1]);"),
    ],
    "sweep/momentum.hpp": [
        ("never-restarts", "if (error <= (1 + growth_) * least_)", "if (true)"),
        ("growth-the-wrong-way", "least_ < lastLeast_ ?", "least_ > lastLeast_ ?"),
    ],
    "sweep/stop_test.hpp": [
        ("stall-never-seen", "- lowestAt_ >= settings_.stallSweeps", "- lowestAt_ > 1000000"),
    ],
    "sweep/packed_island.cpp": [
        ("overflow-not-swept-with-momentum", "from = c.p + momentum * (c.p - c.old)", "from = c.p"),
        ("overflow-not-measured", "total += measuresOf(c.p, relativeVelocity(view, c),",
         "total += measuresOf({}, relativeVelocity(view, c),"),
        ("relaxed-without-projection", "projectCone(c.p + relaxation * (p - c.p), c.friction)",
         "c.p + relaxation * (p - c.p)"),
    ],
    "sweep/packed_island_precision.cpp": [
        ("overflow-without-reference", "c.reference = relativeVelocity(view_, c);", ""),
        ("points-without-reference",
         "packed_.kernels_->updateReference(view_, chunk, singleView_.points);", ""),
        ("momentum-without-the-shift", "? body[i] : old[i] - body[i];", "? body[i] : 0;"),
        ("floats-out-of-range", "(std::abs(value) > 1e-12 && std::abs(value) < 1e12)", "true"),
    ],
    "sweep/packed_problem.cpp": [
        ("reload-keeps-the-overflow", "c.bias              = bias[c.point];", ""),
        ("spin-not-scaled-back", "v[record::spin] * inverseGyration_[i]", "v[record::spin]"),
    ],
    "sweep/lane/lane.hpp": [
        ("min-in-the-other-order", "min_##type(a.value, b.value)", "min_##type(b.value, a.value)"),
    ],
    "sweep/lane/packed_kernels.cpp": [
        ("rounding-accumulates",
         "relativeToReference ? subtractProduct(q - p, beta, last) : q - y", "q - y"),
    ],
    "sweep/lane/point_models.hpp": [
        ("slides-one-way", "max(min(t0, n0 * L::load(c.slidePlus() + lane))", "max(t0"),
        ("friction-without-coupling", "{ subtractProduct(n0, ratio, t), t };", "{ n0, t };"),
    ],
    "delassus/solve_delassus.cpp": [
        ("own-block-counted-twice", ".rowStart[k], diagonal_[k]", ".rowStart[k], diagonal_[k] + 1"),
        ("relaxed-off-the-cone", "projectCone(p + sorRelaxation * (solved - p), friction)",
         "p + sorRelaxation * (solved - p)"),
        ("without-asymmetry", "g.t += (w.tn - w.nt) * p.n;", ""),
        ("driven-bodies-keep-impulses", "problem.impulse[k] = {};", ";"),
        ("pattern-unchecked", "+ problem.rowStart[j + 1], k))", "+ problem.rowStart[j + 1], j))"),
    ],
    "exact/block_lu.cpp": [
        ("inverse-without-exchange", "std::swap(a[largest], a[k]);", ""),
        ("upper-not-eliminated", "subtractProduct(upper_[entry], l, upper_[m]);", ""),
        ("singular-not-seen", "if (!(std::abs(a[largest][k]) > 0)) return false;", ""),
    ],
    "exact/path_following.cpp": [
        ("edge-passed", "-value >= edge.distance * slope", "-value >= edge.distance * slope * 0.5"),
        ("fold-not-seen", "if (!(delta > 0)) {", "if (delta == 0) {"),
        ("update-forgotten", "updates_.push_back({ change, delta, response_ });", ""),
        ("no-shift-of-sliding", "piece.closed = true;\n\t\t\t\t\tshift_[i].n  = -u.n;",
         "piece.closed = true;"),
        ("enters-sticking", "piece.slides.*of = predictor.*of > 0 ? 1 : -1;", ";"),
        ("rolling-without-edges", "for (int row : { 0, 1 }) {", "for (int row : { 0 }) {"),
    ],
    "exact/proximal_problem.cpp": [
        ("bias-forgotten", "{ u.n + contacts[i].bias, u.t,", "{ u.n, u.t,"),
        ("rolling-row-of-one-body", "turn * std::sqrt(m2.rotation),", "0,"),
        ("pair-turned-round", "c.body1 > c.body2 });", "false });"),
    ],
    "exact/solve_exact.cpp": [
        ("last-instead-of-best", "problem.setImpulses(best.impulses);", ""),
    ],
    "exact/proximal_parameter.hpp": [
        ("patience-without-limit", "std::min(maxPatience, 2 * patience_)", "2 * patience_"),
    ],
    "parallel/shared_loop.cpp": [
        ("slices-too-large", "maxSlice  = int(indexMask)", "maxSlice  = int(indexMask) + 1"),
        ("own-part-alone", "for (int k = 0; k < threads_; ++k) {", "for (int k = 0; k < 1; ++k) {"),
        ("begin-forgotten", ", begin_ + int(word & indexMask))", ", int(word & indexMask))"),
    ],
    "parallel/thread_team.hpp": [
        ("last-exception", "if (!error || i < least)", "if (!error || i > least)"),
        ("exception-kept", "if (guarded.error) std::rethrow_exception(guarded.error);", ""),
    ],
    "parallel/parallel_choice.hpp": [
        ("slower-mode", "* tried.fastest >= former.mean()", "* tried.fastest < former.mean()"),
        ("never-tries-the-other", "(!trying_ && rounds_ == interval)", "(!trying_ && rounds_ < 0)"),
        ("slowdown-forgotten",
         "chosen.slowdown = std::clamp(chosen.mean() / chosen.fastest, 1.0, maxSlowdown);", ""),
    ],
    "parallel/thread_pool.cpp": [
        ("start-throws", "} catch (const std::system_error&)", "} catch (const std::bad_alloc&)"),
        ("no-helper-reused", "h.idle || !h.loop->isOpen()", "false"),
        ("children-inherit-helpers",
         "pthread_atfork(nullptr, nullptr, [] { pool = new ThreadPool; });", ""),
        ("never-ends", "std::chrono::seconds(10)", "std::chrono::seconds(1000)"),
    ],
}


def all_mutants():
    return [Mutant(f"{file.split('/')[-1].split('.')[0]}:{name}", f"{KERNEL}/{file}", before, after)
            for file, errors in TABLE.items() for name, before, after in errors]


def tests_of(file):
    """Tests of the file, then of its folder, then all."""
    folder = check.ROOT / check.TESTS / file.split("/")[2]
    own = folder / f"test_{file.split('/')[-1].split('.')[0]}.py"
    found = [str(path.relative_to(check.ROOT)) for path in (own, folder) if path.exists()]
    return [*found, check.TESTS]


def copy_sources(folder):
    for part in ("pkg/kernel", "pkg/python", "cmake"):
        # Copies have a new time, so that files of earlier builds are stale.
        shutil.copytree(check.ROOT / part, folder / part, dirs_exist_ok=True,
                        copy_function=shutil.copy)
    for file in ("CMakeLists.txt", "py/rcr/__init__.py"):
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(check.ROOT / file, folder / file)


def caught(files, package, log):
    """True if a test in these files fails."""
    for tests in files:
        limit = LIMIT if tests == check.TESTS else LIMIT // 4
        command = ["prlimit", f"--cpu={limit}", *check.PYTEST, *check.WITHOUT_YADE, "-x", tests]
        try:
            variables = check.environment(package, OMP_NUM_THREADS="1")
            if check.run(command, log, cwd=check.ROOT, env=variables, timeout=6 * limit):
                return True
        except subprocess.TimeoutExpired:
            return True
    return False


def run(names):
    """Build and test the mutants of these names, or all; returns the verdict and its line."""
    chosen = [mutant for mutant in all_mutants()
              if not names or any(name in mutant.name for name in names)]
    folder, log, flags = check.FOLDER / "mutants" / "source", check.FOLDER / "mutants.log", "-O1"
    copy_sources(folder)
    for mutant in chosen:
        if (folder / mutant.file).read_text().count(mutant.before) != 1:
            found = f"expected '{mutant.before}' once in {mutant.file}"
            return False, f"{mutant.name}: {found}; adapt the mutant to the code"
    package = check.build("mutants", flags, folder)
    if package is None or caught([check.TESTS], package, log):
        return False, f"the kernels as they are do not pass, see {log.relative_to(check.ROOT)}"
    verdicts = {}
    try:
        for number, mutant in enumerate(chosen, 1):
            start = time.monotonic()
            verdicts[mutant.name] = verdict_on(mutant, folder, package, log)
            seconds = f"({time.monotonic() - start:.0f} s)"
            progress = f"check: mutant {number} of {len(chosen)}"
            print(f"{progress}: {mutant.name}: {verdicts[mutant.name]}", seconds, file=sys.stderr,
                  flush=True)
    except KeyboardInterrupt:
        pass
    about = f"{list(verdicts.values()).count('caught')} of {len(verdicts)} caught"
    others = [f"{name} {verdict}" for name, verdict in verdicts.items() if verdict != "caught"]
    return not others, "; ".join([about, *others])


def verdict_on(mutant, folder, package, log):
    """Insert the error of a mutant into the sources in `folder`, build, test, and remove it."""
    source = folder / mutant.file
    whole = source.read_text()
    source.write_text(whole.replace(mutant.before, mutant.after))
    try:
        if not check.compiled("mutants"):
            return "does not build"
        return "caught" if caught(tests_of(mutant.file), package, log) else "SURVIVED"
    finally:
        source.write_text(whole)

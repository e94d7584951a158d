#!/usr/bin/env python3
"""Renew the reference values and print the differences.

    scripts/lib/run python3 tests/regression/renew.py [--dry] [--perturb]
"""

import argparse
import json
import pathlib
import warnings

import cases
import scene_fuzzer

REFERENCE = pathlib.Path(__file__).parent / "reference.json"


def differences(old, new):
    """Rows (case, quantity, old, new, relative difference), the largest first."""
    rows = []
    for case in new:
        for quantity, value in new[case].items():
            before = old.get(case, {}).get(quantity)
            if before != value:
                scale = max(abs(value), abs(before or 0))
                rows.append((abs(value - before) / scale if before is not None else float("inf"),
                             case, quantity, before, value))
    return sorted(rows, key=lambda row: -row[0])


def perturbed(build, by=1e-15):
    """The fuzzer's `build`, with coordinates of grains changed by the factor 1 + `by`."""

    def moved(*arguments):
        build(*arguments)
        for body in scene_fuzzer.loose_grains():
            body.state.pos = body.state.pos * (1 + by)

    return moved


def main():
    parser = argparse.ArgumentParser(prog="renew.py", description=__doc__.splitlines()[0])
    parser.add_argument("--dry", action="store_true", help="show the differences alone")
    parser.add_argument("--perturb", action="store_true", help="show by how much the scenes differ "
                        "if grains are moved by 1e-15 of their coordinates")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    if options.perturb:
        scene_fuzzer.build = perturbed(scene_fuzzer.build)
    old = json.loads(REFERENCE.read_text()) if REFERENCE.exists() else {}
    chosen = cases.SCENES if options.perturb else cases.CASES
    new = {name: cases.CASES[name]() for name in chosen}
    for relative, case, quantity, before, value in differences(old, new):
        print(f"{case}: {quantity} {before} -> {value} ({relative:.1e})")
    for case in old.keys() - cases.CASES.keys():
        print(f"{case}: gone")
    if not (options.dry or options.perturb):
        rows = ",\n".join(f"{json.dumps(name, ensure_ascii=False)}: {json.dumps(numbers)}"
                          for name, numbers in new.items())
        REFERENCE.write_text("{\n" + rows + "\n}\n")


if __name__ == "__main__":
    main()

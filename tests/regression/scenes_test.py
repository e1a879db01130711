#!/usr/bin/env python3
"""Bakes one regression level and compares its light with scenes/expected, its cost with scenes/budgets.json.

    scenes_test.py --programs build/release/bin --levels build/release/scenes --scenes scenes cornell

Tolerance: |got - expected| <= k sqrt(se_got^2 + se_expected^2) + floor * (mean irradiance at the point), with the smaller
k for a share of the values and the larger for all of them; scenes/README.md says why. Prints what it compared; exit status
1 if anything is off.
"""

import argparse
import csv
import io
import json
import math
import pathlib
import subprocess
import sys
import tempfile

AXES = [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)]
AXIS_NAMES = ["+x", "-x", "+y", "-y", "+z", "-z"]


class Check:
    """Counts what was compared and prints what was off."""

    def __init__(self):
        self.compared = 0
        self.failures = 0
        self.values = 0
        self.close_values = 0

    def that(self, holds, text):
        self.compared += 1
        if not holds:
            self.failures += 1
            print("FAIL", text)


class Programs:
    def __init__(self, folder, level, options):
        self.folder = folder
        self.level = level
        self.options = options

    def run(self, program, *arguments):
        command = [str(self.folder / program), *map(str, arguments)]
        result = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        if result.returncode != 0:
            sys.exit(f"{' '.join(command)}\nexit status {result.returncode}\n{result.stderr}")
        return result.stdout

    def bake(self, volume, *arguments):
        report = volume.with_suffix(".json")
        self.run("level-bake", self.level, "-o", volume, "--report-json", report, "--quiet", *self.options, *arguments)
        return json.loads(report.read_text())

    def table(self, *arguments):
        rows = csv.DictReader(io.StringIO(self.run("lightgrid", *arguments)))
        return [{name: float(value) for name, value in row.items()} for row in rows]


def rays_of(report):
    return sum(stage.get("rays", 0) for stage in report["stages"])


def write_points(path, points):
    path.write_text("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points))


def compare(check, what, got, got_se, wanted, wanted_se, rule, scale):
    for channel in range(3):
        se = math.hypot(got_se[channel], wanted_se[channel])
        floor = rule["floor"] * scale[channel]
        tolerance = rule["largest_k"] * se + floor
        off = abs(got[channel] - wanted[channel])
        check.values += 1
        check.close_values += off <= rule["k"] * se + floor
        check.that(off <= tolerance, f"{what} {'rgb'[channel]}: got {got[channel]:.7g}, expected {wanted[channel]:.7g}, "
                                     f"off by {off:.2g}, allowed {tolerance:.2g}")


def compare_points(check, expected, probes, direct, rule):
    """SH of the probes of a bake, and irradiance of the reference, with what is expected at each point."""
    none = [[0.0] * 3] * 9
    for i, point in enumerate(expected["points"]):
        mean = [sum(row[channel] for row in point["irradiance"]) / 6 for channel in range(3)]
        place = f"at {point['point']}:"
        for k in range(9):
            got = [probes[i][f"c{k}{c}"] for c in "rgb"]
            got_se = [probes[i][f"e{k}{c}"] for c in "rgb"]
            compare(check, f"{place} bake, coefficient {k}", got, got_se, point["sh"][k], point.get("sh_se", none)[k], rule,
                    mean)
        for n in range(6):
            row = direct[6 * i + n]
            assert (row["nx"], row["ny"], row["nz"]) == AXES[n]
            got, got_se = [row[c] for c in "rgb"], [row["e" + c] for c in "rgb"]
            compare(check, f"{place} reference, irradiance {AXIS_NAMES[n]}", got, got_se, point["irradiance"][n],
                    point.get("irradiance_se", none)[n], rule, mean)
        # A standard error that is too large would let anything pass.
        first = [probes[i][f"e0{c}"] for c in "rgb"]
        for channel in range(3):
            limit = rule["most_noise"] * abs(point["sh"][0][channel]) + rule["floor"] * mean[channel]
            check.that(first[channel] <= limit, f"{place} standard error of coefficient 0 {'rgb'[channel]} is "
                                                f"{first[channel]:.2g}, allowed {limit:.2g}")


def check_probes(check, programs, budget, expected, rule, folder):
    points = folder / "points.csv"
    write_points(points, [point["point"] for point in expected["points"]])
    volume = folder / "points.probes.exr"
    report = programs.bake(volume, "--probes", points, "--samples", budget["samples"], "--seed", 1)
    probes = programs.table("probes", volume)
    direct = programs.table("reference", programs.level, "--points", points, "--samples", budget["samples"], "--seed", 2,
                            *programs.options)
    check.that(len(probes) == len(expected["points"]), f"{len(probes)} probes, {len(expected['points'])} points")
    compare_points(check, expected, probes, direct, rule)
    share = check.close_values / check.values
    check.that(share >= rule["share"], f"{share:.1%} of the values within {rule['k']} standard errors, {rule['share']:.0%} wanted")
    print(f"{check.values} values, {share:.1%} within {rule['k']} standard errors")
    rays = rays_of(report)
    print(f"{len(probes)} probes: {rays} rays, budget {budget['rays']}")
    check.that(0 < rays <= budget["rays"], f"{rays} rays, budget {budget['rays']}")


def check_grid(check, programs, budget, rule, folder):
    """A bake as a user makes it: its size, what it reports, and no light where none can be."""
    volume = folder / "grid.probes.exr"
    report = programs.bake(volume, "--spacing", budget["spacing"], "--samples", budget["samples"], "--seed", 1)
    rays, size = rays_of(report), volume.stat().st_size
    error = report["error"]
    low, high = error["interval"]
    print(f"grid: {rays} rays, budget {budget['rays']}; {size} bytes, budget {budget['bytes']}; "
          f"error {error['relrmse']:.3%} ({low:.3%} to {high:.3%}), budget {budget['error']:.3%}")
    check.that(0 < rays <= budget["rays"], f"{rays} rays, budget {budget['rays']}")
    check.that(size <= budget["bytes"], f"{size} bytes, budget {budget['bytes']}")
    check.that(low <= budget["error"], f"error {error['relrmse']:.3%}, budget {budget['error']:.3%}")

    if "dark" in budget:
        x0, y0, z0, x1, y1, z1 = budget["dark"]
        inside = [row for row in programs.table("probes", volume)
                  if row["valid"] and x0 <= row["x"] <= x1 and y0 <= row["y"] <= y1 and z0 <= row["z"] <= z1]
        check.that(len(inside) > 0, "no valid probe in the dark room")
        for row in inside:
            for k in range(9):
                for c in "rgb":
                    check.that(abs(row[f"c{k}{c}"]) <= 3 * row[f"e{k}{c}"],
                               f"dark probe at {row['x']}, {row['y']}, {row['z']}: c{k}{c} = {row[f'c{k}{c}']}")
        # Plain trilinear interpolation brings light through the wall. How much is printed, not approved: what covers it is
        # the interpolation error that the bake reports.
        points = folder / "dark.csv"
        middle = [(y0 + y1) / 2, (z0 + z1) / 2]
        write_points(points, [(x0 + step * budget["spacing"], *middle) for step in (0.05, 0.25, 0.5, 1.0, 1.5)])
        worst = 0
        for row in programs.table("query", volume, "--points", points):
            worst = max(worst, abs(row["g"]))
            if (row["nx"], row["ny"], row["nz"]) == (0, 1, 0):
                print(f"leak at {row['x'] - x0:.3f} m behind the wall: {row['g']:.4g} lx")
        interpolation = error["parts"]["interpolation"]
        print(f"reported interpolation error: {interpolation['relrmse']:.3%}")
        if worst > 0:
            check.that(interpolation["interval"][1] > 0, "the volume leaks, and the report shows no interpolation error")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--programs", type=pathlib.Path, required=True, help="folder of level-bake and lightgrid")
    arguments.add_argument("--levels", type=pathlib.Path, required=True, help="folder that make_scenes wrote")
    arguments.add_argument("--scenes", type=pathlib.Path, required=True, help="folder of budgets.json and expected/")
    arguments.add_argument("level", help="its name, without .glb")
    chosen = arguments.parse_args()

    budgets = json.loads((chosen.scenes / "budgets.json").read_text())
    budget, rule = budgets["levels"][chosen.level], budgets["rule"]
    expected = json.loads((chosen.scenes / "expected" / f"{chosen.level}.json").read_text())
    programs = Programs(chosen.programs, chosen.levels / f"{chosen.level}.glb", expected["options"])
    check = Check()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_probes(check, programs, budget["probes"], expected, rule, folder)
        if "grid" in budget:
            check_grid(check, programs, budget["grid"], rule, folder)
    print(f"{chosen.level}: {check.compared} comparisons, {check.failures} off; expected from: {expected['source']}")
    return 1 if check.failures or not check.compared else 0


if __name__ == "__main__":
    sys.exit(main())

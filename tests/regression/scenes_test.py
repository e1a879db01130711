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
import random
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
        self.noise = 0.0  # largest relative standard error of L_0

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

    def bake(self, volume, *arguments, level=None):
        report = volume.with_suffix(".json")
        self.run("level-bake", level or self.level, "-o", volume, "--report-json", report, "--quiet", *self.options, *arguments)
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
        for c, channel in zip("rgb", range(3)):
            noise, light = probes[i][f"e0{c}"], abs(point["sh"][0][channel])
            check.that(noise <= rule["most_noise"] * light, f"{place} standard error of coefficient 0 {c} is {noise:.2g} of "
                                                            f"{light:.3g}, allowed {rule['most_noise']:.2%}")
            if light > 0:
                check.noise = max(check.noise, noise / light)


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
    print(f"{check.values} values, {share:.1%} within {rule['k']} standard errors; noise of L_0 up to {check.noise:.2%}")
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
        check_dark_room(check, programs, budget, volume, report, folder)


def inside(box, row):
    return all(box[i] <= row[axis] <= box[i + 3] for i, axis in enumerate("xyz"))


def check_dark_room(check, programs, budget, volume, report, folder):
    """Every probe in the dark reads 0. Plain trilinear interpolation still brings light through the wall: how much is
    printed, not approved, and the error that the bake reports must account for it."""
    probes = [row for row in programs.table("probes", volume) if row["valid"] and inside(budget["dark"], row)]
    check.that(len(probes) > 0, "no valid probe in the dark room")
    for row in probes:
        for k in range(9):
            for c in "rgb":
                check.that(abs(row[f"c{k}{c}"]) <= 3 * row[f"e{k}{c}"],
                           f"dark probe at {row['x']}, {row['y']}, {row['z']}: c{k}{c} = {row[f'c{k}{c}']}")

    points = folder / "anywhere.csv"
    draw = random.Random(1)
    off_walls = 0.01 * budget["spacing"]  # as near as the bake's own held-out points come
    anywhere = [[draw.uniform(box[i] + off_walls, box[i + 3] - off_walls) for i in range(3)]
                for box in (budget["lit"], budget["dark"]) for _ in range(600)]
    write_points(points, anywhere)
    ours = programs.table("query", volume, "--points", points)
    a, b = (programs.table("reference", programs.level, "--points", points, "--samples", 256, "--seed", seed,
                           *programs.options) for seed in (11, 12))
    leaks = sorted(((row["g"], row["x"] - budget["dark"][0]) for row in ours if inside(budget["dark"], row)), reverse=True)
    print("strongest leaks: " + ", ".join(f"{lux:.3g} lx {x:.3f} m behind the wall" for lux, x in leaks[:3]))

    # The same measure as the bake's (sum (E - A)(E - B) / sum A B, points are the sampling unit), from other points.
    parts = []
    for i in range(0, len(ours), 6):
        pairs = [(ours[n][c], a[n][c], b[n][c]) for n in range(i, i + 6) for c in "rgb"]
        parts.append((sum((e - x) * (e - y) for e, x, y in pairs), sum(x * y for _, x, y in pairs)))
    def squared_error(chosen):
        return sum(parts[i][0] for i in chosen) / sum(parts[i][1] for i in chosen)
    resampled = sorted(squared_error(draw.choices(range(len(parts)), k=len(parts))) for _ in range(1000))
    low, high = (math.sqrt(max(resampled[i], 0)) for i in (25, 975))
    reported = report["error"]["interval"]
    print(f"error at {len(parts)} points of our own: {low:.2%} to {high:.2%}; reported: {reported[0]:.2%} to {reported[1]:.2%}")
    check.that(low <= reported[1] and reported[0] <= high, "the reported error does not account for what is found")


def difference(rows, others):
    """Of irradiance, relative RMS."""
    squares = [((row[c] - other[c]) ** 2, other[c] ** 2) for row, other in zip(rows, others, strict=True) for c in "rgb"]
    return math.sqrt(sum(square for square, _ in squares) / sum(light for _, light in squares))


def check_layers(check, programs, budget, grid, folder):
    """Layers add up to all light, and without one of them they are the light of a level that never had its group: to the
    rounding of a file, and as near as two bakes of different seeds are."""
    off = budget["off"]
    dark_level = programs.level.with_stem(f"{programs.level.stem}_without_{off}")
    effort = ["--spacing", grid["spacing"], "--samples", budget["samples"]]
    layered = folder / "layered.probes.exr"
    report = programs.bake(layered, *effort, "--seed", 1, "--layers", "groups")
    names = [layer["name"] for layer in report["layers"]]
    check.that(off in names and "other" in names and len(names) > 2, f"layers are {', '.join(names)}")
    rays, size = rays_of(report), layered.stat().st_size
    print(f"layers {', '.join(names)}: {rays} rays, budget {budget['rays']}; {size} bytes, budget {budget['bytes']}")
    check.that(0 < rays <= budget["rays"], f"{rays} rays, budget {budget['rays']}")
    check.that(size <= budget["bytes"], f"{size} bytes, budget {budget['bytes']}")

    points = folder / "probes.csv"
    write_points(points, [[row[axis] for axis in "xyz"] for row in programs.table("probes", layered) if row["valid"]])

    def light(volume, *arguments):
        return programs.table("query", volume, "--points", points, *arguments)

    def mixed(weight_of_off):
        weights = ",".join(f"{name}={weight_of_off if name == off else 1}" for name in names)
        return light(layered, "--layers", weights)

    def two_bakes(level):
        """The light of one, and how far another is off it."""
        volumes = [folder / f"{level.stem}_{seed}.probes.exr" for seed in (2, 3)]
        for seed, volume in zip((2, 3), volumes):
            programs.bake(volume, *effort, "--seed", seed, level=level)
        first, second = map(light, volumes)
        return first, difference(second, first)

    rounding = difference(mixed(1), light(layered))
    check.that(rounding <= 0.001, f"the sum of all layers is {rounding:.2%} off the combined light")  # half: 0.05 %
    print(f"the sum of all layers is {rounding:.3%} off the combined light")
    for weight, level in ((1, programs.level), (0, dark_level)):
        fresh, usual = two_bakes(level)
        found, other = (difference(mixed(w), fresh) for w in (weight, 1 - weight))
        result = (f"{off}={weight}: {found:.2%} off a bake of {level.name} without layers, two of which are {usual:.2%} off "
                  f"each other; {off}={1 - weight}: {other:.2%}")
        print(result)
        check.that(found <= 1.5 * usual < other, result)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--programs", type=pathlib.Path, required=True, help="folder of level-bake and lightgrid")
    arguments.add_argument("--levels", type=pathlib.Path, required=True, help="folder that make_scenes wrote")
    arguments.add_argument("--scenes", type=pathlib.Path, required=True, help="folder of budgets.json and expected/")
    arguments.add_argument("level", help="its name, without .glb")
    chosen = arguments.parse_args()

    budgets = json.loads((chosen.scenes / "budgets.json").read_text())
    budget = budgets["levels"][chosen.level]
    rule = budgets["rule"] | budget.get("rule", {})
    expected = json.loads((chosen.scenes / "expected" / f"{chosen.level}.json").read_text())
    programs = Programs(chosen.programs, chosen.levels / f"{chosen.level}.glb", expected["options"])
    check = Check()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_probes(check, programs, budget["probes"], expected, rule, folder)
        if "grid" in budget:
            check_grid(check, programs, budget["grid"], rule, folder)
        if "layers" in budget:
            check_layers(check, programs, budget["layers"], budget["grid"], folder)
    print(f"{chosen.level}: {check.compared} comparisons, {check.failures} off; expected from: {expected['source']}")
    return 1 if check.failures or not check.compared else 0


if __name__ == "__main__":
    sys.exit(main())

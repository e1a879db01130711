#!/usr/bin/env python3
"""Lightgrid beside Mitsuba 3's `path` integrator: time at equal error, on the same probes of the same triangles.

    against_mitsuba.py [options] LEVEL[@ENVIRONMENT] ...

Both gather light at the same points, on the same number of threads, in alternating rounds with new seeds. Each round
gives 9 SH coefficients per point and from them irradiance along the six axes. Their variance over the rounds, summed
over points, axes and colours and divided by the same sum of squared means, is the squared error of a round; error falls
with the root of time, so time x squared error is the cost of a given error, and its ratio is what is printed: below 1
Lightgrid is quicker. The ratio is also given with each point's error relative to its own light ("by point"), which dark
points decide. Intervals (95 %) come from resampling points.

Mitsuba shoots independent uniform directions, each followed by `path` (no depth limit, roulette from depth 5). That
leaves lamps that a probe sees to be met by chance, so a second variant (`path + nee`) samples emitters at the probe too
and weighs both by the power-balance heuristic, as its own sensors cannot. Its kernels are compiled in a first round that
does not count, as does neither program's loading.

With --method path Lightgrid gathers at these points alone, by paths. With --method cache it bakes the whole grid that
they are picked from, and they are charged their share of its cache and gathers. Each round makes a cache of its own, so
that its noise counts as error; what all caches are off by the same (cache_against_path.cpp measures it) does not.

Time is processor time of all threads (steady on a machine that does other work); wall-clock time stands beside it.

Needs: pip install mitsuba numpy, and LLVM for its fast variant (on Debian libllvm19; DRJIT_LIBLLVM_PATH names the
library). Without LLVM, --variant scalar_rgb works but is many times slower than Mitsuba at its best.
"""

import argparse
import csv
import io
import json
import os
import pathlib
import resource
import statistics
import subprocess
import tempfile
import time

import numpy as np

AXES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)


def sh_basis(x, y, z):
    """Real orthonormal SH of 3 bands without the Condon-Shortley phase; works on numpy and Dr.Jit arrays."""
    return [
        0.28209479177387814 + 0 * x,
        0.4886025119029199 * y,
        0.4886025119029199 * z,
        0.4886025119029199 * x,
        1.0925484305920792 * x * y,
        1.0925484305920792 * y * z,
        0.31539156525252005 * (3 * z * z - 1),
        1.0925484305920792 * x * z,
        0.5462742152960396 * (x * x - y * y),
    ]


# From coefficients to irradiance along the axes: A_l Y_i(n).
TO_IRRADIANCE = np.array(sh_basis(*AXES.T)).T * (np.pi * np.array([1] + [2 / 3] * 3 + [1 / 4] * 5))


class Lightgrid:
    def __init__(self, programs, level, environment, threads, folder):
        self.programs, self.folder, self.threads = programs, folder, threads
        self.light = [level, "--threads", str(threads)]
        if environment:
            self.light += ["--environment", environment]

    def run(self, program, *arguments):
        command = [self.programs / program, *map(str, arguments)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def probes_of(self, volume):
        return list(csv.DictReader(io.StringIO(self.run("lightgrid", "probes", volume))))

    def bake(self, *options):
        """Positions, validity and coefficients of the probes, processor time of the program, seconds by stage."""
        volume, report = self.folder / "volume.probes.exr", self.folder / "report.json"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        self.run("level-bake", *self.light, "-o", volume, "--report-json", report, "--quiet", *options)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        processor_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        rows = self.probes_of(volume)
        positions = np.array([[float(row[c]) for c in "xyz"] for row in rows])
        valid = np.array([row["valid"] == "1" for row in rows])
        coefficients = np.array([[[float(row[f"c{i}{c}"]) for c in "rgb"] for i in range(9)] for row in rows])
        stages = {stage["name"]: stage["seconds"] for stage in json.loads(report.read_text())["stages"]}
        return positions, valid, coefficients, processor_s, stages

    def choose_points(self, count, seeds):
        """Probes of a grid that are valid, and stand in the same place, with all of the seeds; evenly picked."""
        places = []
        for seed in seeds:
            positions, valid, *_ = self.bake("--samples", 16, "--seed", seed, *self.grid(count))
            places.append({tuple(point) for point in positions[valid].tolist()})
        points = np.array(sorted(set.intersection(*places)))
        # Not those on the bounds themselves, which walls may share.
        margin = 0.02 * (points.max(axis=0) - points.min(axis=0))
        points = points[np.all((points > points.min(axis=0) + margin) & (points < points.max(axis=0) - margin), axis=1)]
        return points[np.random.default_rng(1).permutation(len(points))[:count]]

    @staticmethod
    def grid(count):
        return "--max-probes", 64 * count

    def gather_in_grid(self, points, samples, seed):
        """By the cache, with the share of these points in its time."""
        grid = self.grid(len(points))
        positions, valid, coefficients, _, stages = self.bake("--samples", samples, "--seed", seed, *grid)
        rows = {tuple(position): i for i, position in enumerate(positions.tolist())}
        wall_s = (stages["cache"] + stages["gather"]) * len(points) / valid.sum()
        # All threads are busy in both stages.
        return coefficients[[rows[tuple(point)] for point in points.tolist()]], self.threads * wall_s, wall_s

    def gather_list(self, points_file, samples, seed):
        """By paths: coefficients, processor time, wall-clock time of the gather."""
        bake = lambda count: self.bake("--method", "path", "--probes", points_file, "--samples", count, "--seed", seed)
        _, _, coefficients, processor_s, stages = bake(samples)
        # What is not gathering costs the same with next to no samples.
        return coefficients, processor_s - min(bake(16)[3] for _ in range(2)), stages["gather"]


class Mitsuba:
    def __init__(self, variant, scene_file, environment, threads, points):
        import drjit as dr
        import mitsuba as mi

        self.dr, self.mi = dr, mi
        mi.set_variant(variant)
        if variant.startswith("llvm"):
            dr.set_thread_count(threads)
        mi.set_log_level(mi.LogLevel.Error)
        text = scene_file.read_text()
        if environment:
            # u = 1/2 is +X here and +Z there.
            text = text.replace("</scene>", f"""<emitter type="envmap"><string name="filename" value="{environment}"/>
                <transform name="to_world"><rotate y="1" angle="90"/></transform></emitter></scene>""")
        (scene_file.parent / "lit.xml").write_text(text)
        self.scene = mi.load_file(str(scene_file.parent / "lit.xml"))
        self.path = mi.load_dict({"type": "path", "max_depth": -1, "rr_depth": 5})
        self.points = points
        self.seed = 0

    def gather(self, samples, at_probe):
        """Coefficients, in batches that fit in memory."""
        dr, mi = self.dr, self.mi
        count = len(self.points)
        batch = min(samples, max(1, (1 << 22) // count))
        sums = np.zeros((count, 9, 3))
        start = time.process_time(), time.perf_counter()
        for _ in range(samples // batch):
            self.seed += 1
            sampler = mi.load_dict({"type": "independent"})
            sampler.seed(self.seed, count * batch)
            origin = mi.Point3f(*(dr.repeat(mi.Float(self.points[:, k]), batch) for k in range(3)))
            direction = mi.warp.square_to_uniform_sphere(sampler.next_2d())
            parts = self.along(sampler, origin, direction)
            if at_probe:
                parts = self.emitters_by_mis(sampler, origin, direction, parts[0][1])
            dr.eval(parts)  # once: each sum below would trace anew
            values = []
            for d, radiance in parts:
                for basis in sh_basis(d.x, d.y, d.z):
                    values += [dr.block_sum(basis * radiance[c], batch) for c in range(3)]
            dr.eval(values)
            sums += sum(np.array(values[27 * i:27 * i + 27], dtype=float).reshape(9, 3, count).transpose(2, 0, 1)
                        for i in range(len(parts)))
        spent = time.process_time() - start[0], time.perf_counter() - start[1]
        return 4 * np.pi * sums / (samples // batch * batch), *spent

    def along(self, sampler, origin, direction):
        ray = self.mi.RayDifferential3f(origin, direction)
        return [(direction, self.path.sample(self.scene, sampler, ray)[0])]

    def emitters_by_mis(self, sampler, origin, direction, radiance):
        """Emission met at once loses what emitter sampling brings, and that is added."""
        dr, mi = self.dr, self.mi
        density = 1 / (4 * dr.pi)
        probe = dr.zeros(mi.SurfaceInteraction3f)
        probe.p = origin
        met = self.scene.ray_intersect(mi.Ray3f(origin, direction))
        emitter = met.emitter(self.scene)
        other = self.scene.pdf_emitter_direction(probe, mi.DirectionSample3f(self.scene, met, probe), emitter != None)
        radiance = radiance - emitter.eval(met) * other / (other + density)
        there, weight = self.scene.sample_emitter_direction(probe, sampler.next_2d(), True)
        return [(direction, radiance),
                (there.d, weight * there.pdf / (there.pdf + density) / (4 * dr.pi))]


def squared_errors(rounds):
    """Per point: variance and squared mean of irradiance, summed over axes and colours."""
    irradiance = np.einsum("ni,rpic->rpnc", TO_IRRADIANCE, np.array(rounds))
    return irradiance.var(axis=0, ddof=1).sum(axis=(1, 2)), (irradiance.mean(axis=0) ** 2).sum(axis=(1, 2))


def pooled(variance, light):
    return variance.sum() / light.sum()


def by_point(variance, light):
    lit = light > 1e-4 * np.median(light)  # 1 % of the median irradiance
    return (variance[lit] / light[lit]).mean()


def interval(error, ours, theirs, times):
    random = np.random.default_rng(0)
    ratios = []
    for _ in range(1000):
        pick = random.integers(len(ours[0]), size=len(ours[0]))
        ratios.append(times * error(*(a[pick] for a in ours)) / error(*(a[pick] for a in theirs)))
    return np.percentile(ratios, [2.5, 97.5])


def compare(options, level, environment):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        subprocess.run([options.programs / "bench_export_level", level, folder / "scene"], check=True)
        ours = Lightgrid(options.programs, level, environment, options.threads, folder)
        seeds = range(options.rounds + 1)
        points = ours.choose_points(options.points, seeds if options.method == "cache" else [0])
        points_file = folder / "points.csv"
        points_file.write_text("x,y,z\n" + "".join(f"{x!r},{y!r},{z!r}\n" for x, y, z in points.tolist()))
        theirs = Mitsuba(options.variant, folder / "scene" / "scene.xml", environment, options.threads, points)
        gathers = {
            "lightgrid": lambda seed: (ours.gather_list(points_file, options.samples, seed) if options.method == "path"
                                       else ours.gather_in_grid(points, options.samples, seed)),
            "path": lambda seed: theirs.gather(options.mitsuba_samples, False),
            "path + nee": lambda seed: theirs.gather(options.mitsuba_samples, True),
        }
        rounds = {name: [] for name in gathers}
        for seed in seeds:
            for name, gather in gathers.items():
                result = gather(seed)
                if seed > 0:  # the first compiles
                    rounds[name].append(result)

    print(f"{level}{' in ' + environment if environment else ''}: {len(points)} probes, {options.rounds} rounds")
    errors = {name: squared_errors([r[0] for r in results]) for name, results in rounds.items()}
    mean = np.mean([r[0] for r in rounds["lightgrid"]], axis=0)
    for name, results in rounds.items():
        samples = options.samples if name == "lightgrid" else options.mitsuba_samples
        processor, wall = ([r[k] for r in results] for k in (1, 2))
        difference = np.mean([r[0] for r in results], axis=0)[:, 0].sum() / mean[:, 0].sum() - 1
        print(f"  {name:10}  {samples:6} samples  {statistics.median(processor):6.2f} s of processor time "
              f"({min(processor):.2f} to {max(processor):.2f}), {statistics.median(wall):6.2f} s wall;  error "
              f"{100 * pooled(*errors[name]) ** 0.5:5.2f} %, by point {100 * by_point(*errors[name]) ** 0.5:5.2f} %;  "
              f"light {100 * difference:+.2f} %")
    for name in list(gathers)[1:]:
        for label, k in (("processor", 1), ("wall", 2)):
            # Rounds alternate, so the ratio of neighbours is steadier than that of medians.
            times = [a[k] / b[k] for a, b in zip(rounds["lightgrid"], rounds[name])]
            time_ratio = statistics.median(times)
            line = f"  time at equal error / {name:10} by {label:9}:"
            for error in (pooled, by_point):
                ratio = time_ratio * error(*errors["lightgrid"]) / error(*errors[name])
                least, most = interval(error, errors["lightgrid"], errors[name], time_ratio)
                line += f"  {ratio:.2f} ({least:.2f} to {most:.2f}) {error.__name__.replace('_', ' ')}"
            print(line, flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("levels", nargs="+", metavar="LEVEL[@ENVIRONMENT]")
    parser.add_argument("--programs", type=pathlib.Path, default=pathlib.Path("build/release/bin"))
    parser.add_argument("--method", choices=["path", "cache"], default="path")
    parser.add_argument("--points", type=int, default=256)
    parser.add_argument("--samples", type=int, default=4096, help="of Lightgrid, per probe and round")
    parser.add_argument("--mitsuba-samples", type=int, default=4096, help="of Mitsuba, per probe and round")
    parser.add_argument("--rounds", type=int, default=8)
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--variant", default="llvm_ad_rgb")
    options = parser.parse_args()
    for level in options.levels:
        compare(options, *(level.split("@") + [None])[:2])


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""Bakes every file that the data's INDEX.md lists, as a user would, and checks what came out.

    tests/robustness/all_levels.py --programs build/release/bin --data ../shared/data             everything, defaults
    tests/robustness/all_levels.py ... --match level-webxr --options "--samples 64"               some, faster
    tests/robustness/all_levels.py ... --csv levels.csv                                           the figures as CSV

Every file of the tables of levels, maps, kits, objects and features is baked with defaults, plus `--sky 1,1,1` where it
has neither lights nor emitters of its own. A bake passes if

- level-bake exits with 0 within the limit of time (5 minutes on two cores; the processor time of both cores counts, so
  that a busy machine fails nobody),
- standard output is JSON and nothing else, and the volume that it names is there and holds together,
- no probe that a level's own `lightgrid info` calls valid is without a finite value (the reader checks that),
- the estimate printed before the bake is within a factor of --estimate of what it took, where that is over 2 seconds.

Printed for each: processor seconds and their ratio to the estimate, millions of rays, probes, shares of moved and of
invalid ones, samples, error and noise, share of valid probes without any light, the brightest probe against the median,
and notices. Figures are for eyes: what a level should look like is not known here.
"""

import argparse
import csv
import json
import os
import re
import shlex
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path


@dataclass
class Level:
    file: str
    lit: bool  # lights or emitters of its own


def read_index(data: Path) -> list[Level]:
    """The rows of the tables whose columns are file, triangles, ..., lights, emit."""
    levels = []
    for line in (data / "INDEX.md").read_text().splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if len(cells) == 9 and re.search(r"\.(glb|gltf)$", cells[0]):
            levels.append(Level(cells[0], cells[4] != "0" or cells[5] != "0"))
    return levels


@dataclass
class Outcome:
    file: str
    problems: list[str] = field(default_factory=list)
    figures: dict = field(default_factory=dict)
    notices: list[str] = field(default_factory=list)


def run_timed(command: list[str], wall_limit_s: float) -> tuple[int, str, str, float, float]:
    """Exit status (negative: a signal), standard output and error, processor seconds, MB of memory at most."""
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=out, stderr=err)
        deadline = time.monotonic() + wall_limit_s
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            if pid != 0:
                break
            if time.monotonic() > deadline:
                process.kill()
                pid, status, usage = os.wait4(process.pid, 0)
                break
            time.sleep(0.02)
        process.returncode = os.waitstatus_to_exitcode(status)
        texts = []
        for stream in (out, err):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
        return process.returncode, texts[0], texts[1], usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def look_at_probes(lightgrid: Path, volume: Path) -> dict:
    """Mean radiance of the valid probes: how many have none, and the brightest against the median."""
    rows = csv.reader(subprocess.run([lightgrid, "probes", volume], capture_output=True, text=True, check=True)
                      .stdout.splitlines())
    header = next(rows)
    colour = [header.index(name) for name in ("c0r", "c0g", "c0b")]
    valid = header.index("valid")
    light = sorted(sum(float(row[i]) for i in colour) / 3 for row in rows if row[valid] == "1")
    if not light:
        return {"black": 0.0, "peak": 0.0}
    middle = statistics.median(light)
    return {"black": sum(value <= 0 for value in light) / len(light),
            "peak": light[-1] / middle if middle > 0 else float("inf")}


def bake(level: Level, arguments: argparse.Namespace, folder: Path) -> Outcome:
    outcome = Outcome(level.file)
    volume = folder / "level.probes.exr"
    volume.unlink(missing_ok=True)
    command = [str(arguments.programs / "level-bake"), str(arguments.data / level.file), "-o", str(volume), "--json",
               "--threads", "2", *shlex.split(arguments.options)]
    if not level.lit:
        command += ["--sky", "1,1,1"]
    # Ten times the limit: a machine may have other things to do.
    status, out, err, seconds, memory = run_timed(command, 10 * arguments.limit)
    outcome.notices = [line for line in err.splitlines() if re.match(r"(level-bake: )?(notice|warning):", line)]
    outcome.figures = {"cpu": seconds, "MB": memory}
    if status != 0:
        outcome.problems.append(f"exit status {status}: {err.splitlines()[-1] if err else 'no message'}")
        return outcome
    if seconds / 2 > arguments.limit:
        outcome.problems.append(f"{seconds / 2:.0f} s on two cores, more than {arguments.limit:.0f}")
    try:
        report = json.loads(out)
    except json.JSONDecodeError as error:
        outcome.problems.append(f"standard output is not JSON: {error}")
        return outcome
    if not volume.is_file():
        outcome.problems.append("no volume was written")
        return outcome

    probes = report["probes"]
    total = probes["valid"] + probes["moved"] + probes["invalid"]
    rays = sum(stage["rays"] for stage in report["stages"])
    traced = sum(stage["seconds"] for stage in report["stages"] if stage["name"] in ("gather", "reference"))
    estimate = report["estimate"]["seconds"]
    error = report["error"]["relrmse"]
    outcome.figures |= {"wall": traced, "estimate": estimate, "Mrays": rays * 1e-6, "probes": total,
                        "moved": probes["moved"] / total, "invalid": probes["invalid"] / total,
                        "filled": probes["filled"], "samples": report["samples"], "noise": report["noise"],
                        "error": error, "interpolation": (report["error"]["parts"]["interpolation"] or {}).get("relrmse")}
    outcome.figures |= look_at_probes(arguments.programs / "lightgrid", volume)
    if traced > 2 and not 1 / arguments.estimate <= estimate / traced <= arguments.estimate:
        outcome.problems.append(f"estimated {estimate:.3g} s, took {traced:.3g} s")
    return outcome


COLUMNS = [("cpu", "{:.1f}"), ("wall", "{:.1f}"), ("estimate", "{:.1f}"), ("Mrays", "{:.0f}"), ("MB", "{:.0f}"),
           ("probes", "{}"), ("moved", "{:.1%}"), ("invalid", "{:.1%}"), ("filled", "{}"), ("samples", "{}"),
           ("noise", "{:.1%}"), ("error", "{:.1%}"), ("interpolation", "{:.1%}"), ("black", "{:.1%}"), ("peak", "{:.3g}")]


def row(outcome: Outcome) -> list[str]:
    cells = [outcome.file]
    for name, form in COLUMNS:
        value = outcome.figures.get(name)
        cells.append("" if value is None else form.format(value))
    return cells + ["; ".join(outcome.problems)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=Path, required=True, help="folder of level-bake and lightgrid")
    parser.add_argument("--data", type=Path, required=True, help="folder of INDEX.md")
    parser.add_argument("--match", default="", help="only files whose path matches this regular expression")
    parser.add_argument("--options", default="", help="more options for level-bake")
    parser.add_argument("--limit", type=float, default=300, help="seconds on two cores")
    parser.add_argument("--estimate", type=float, default=2, help="factor by which the estimate may be off")
    parser.add_argument("--csv", type=Path, help="write the table there too")
    parser.add_argument("--notices", action="store_true", help="print what level-bake noticed")
    arguments = parser.parse_args()
    if not (arguments.data / "INDEX.md").is_file():
        print(f"SKIPPED: there is no {arguments.data / 'INDEX.md'}")
        return 0
    levels = [level for level in read_index(arguments.data) if re.search(arguments.match, level.file)]
    if not levels:
        print(f"nothing in INDEX.md matches \"{arguments.match}\"")
        return 1

    header = ["file", *(name for name, _ in COLUMNS), "problems"]
    print("| " + " | ".join(header) + " |\n|" + "---|" * len(header), flush=True)
    outcomes = []
    with tempfile.TemporaryDirectory(prefix="all-levels-") as folder:
        for level in levels:
            outcomes.append(bake(level, arguments, Path(folder)))
            print("| " + " | ".join(row(outcomes[-1])) + " |", flush=True)
            if arguments.notices:
                for notice in outcomes[-1].notices:
                    print("    " + notice, flush=True)
    if arguments.csv:
        with arguments.csv.open("w", newline="") as file:
            csv.writer(file).writerows([header, *map(row, outcomes)])
    failed = [outcome for outcome in outcomes if outcome.problems]
    print(f"\n{len(outcomes)} files, {len(failed)} with problems")
    for outcome in failed:
        print(f"{outcome.file}: {'; '.join(outcome.problems)}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

#!/usr/bin/env python3
"""Bakes levels with time budgets, and prints when each bake ended and what error it left.

    tests/bench/time_budgets.py --programs build/release/bin --scenes build/release/scenes --data ../shared/data
    tests/bench/time_budgets.py ... --match 'cornell|hall' --budgets 30,120      some levels, other budgets (seconds)
    tests/bench/time_budgets.py ... --budgets ''                                 no budgets: what the defaults take
    tests/bench/time_budgets.py ... --stages                                     and a line with seconds of each stage

"Ended" is on the wall clock, from the start of the program to its end. "Processor" is its processor time over the
number of threads: where it is much less than what ended, other programs had the rest of the machine, and the error is
that of a shorter bake. The error is the measured relRMSE of all parts together, with its 95 % interval. A row ends with
a mark where the budget is missed by more than a tenth. Levels that are not there are left out.
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# Name, folder, file, light.
LEVELS = [
    ("cornell", "scenes", "cornell.glb", ""),
    ("default", "scenes", "default.glb", ""),
    ("courtyard", "scenes", "courtyard.glb", "--sun-sky 40,180"),
    ("bevy-CornellBox", "data", "level-bevy-CornellBox/CornellBox.glb", ""),
    ("bakedgi-CornellBox", "data", "level-bakedgi-CornellBox/CornellBox.glb", ""),
    ("breakfast-room, HDR", "data", "level-bitterli-breakfast-room/scene.gltf",
     "--environment {data}/env-polyhaven-1k/apartment.hdr"),
    ("breakfast-room, sky", "data", "level-bitterli-breakfast-room/scene.gltf", "--sky 1,1,1"),
    ("veach-ajar", "data", "level-bitterli-veach-ajar/scene.gltf", ""),
    ("modern-hall", "data", "level-bitterli-modern-hall/scene.gltf", ""),
    ("contemporary-bathroom", "data", "level-bitterli-contemporary-bathroom/scene.gltf", ""),
    ("littlest-tokyo", "data", "level-littlest-tokyo/LittlestTokyo.glb", ""),
    ("zdm2", "data", "level-zdm2/zdm2.glb", "--sky 1,1,1"),
]


def percent(share: float) -> str:
    return f"{100 * share:.3g}"


def bake(command: list[str], report: Path) -> tuple[int, str, float, float]:
    """Exit status, standard error, wall clock and processor seconds; the report is in the file."""
    start = time.monotonic()
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    message = process.stderr.read().decode(errors="replace")
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, message, time.monotonic() - start, usage.ru_utime + usage.ru_stime


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=Path, required=True, help="folder of level-bake")
    parser.add_argument("--scenes", type=Path, required=True, help="folder of cornell.glb and the others")
    parser.add_argument("--data", type=Path, required=True, help="folder of the levels that are not of the repo")
    parser.add_argument("--match", default="", help="only levels whose name matches this regular expression")
    parser.add_argument("--budgets", default="30,60", help="seconds, with commas between; empty: defaults instead")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--stages", action="store_true", help="print what the stages took as well")
    arguments = parser.parse_args()

    print("| level | asked, s | ended, s | processor, s | probes | error, % | of that noise, interpolation, bands | |")
    print("|---|---|---|---|---|---|---|---|", flush=True)
    failed = baked = 0
    with tempfile.TemporaryDirectory(prefix="time-budgets-") as folder:
        report, volume = Path(folder) / "report.json", Path(folder) / "level.probes.exr"
        for name, place, file, light in LEVELS:
            level = getattr(arguments, place) / file
            if not re.search(arguments.match, name) or not level.is_file():
                continue
            for asked in arguments.budgets.split(","):
                command = [str(arguments.programs / "level-bake"), str(level), "-o", str(volume), "--quiet",
                           "--report-json", str(report), "--threads", str(arguments.threads),
                           *shlex.split(light.format(data=arguments.data))]
                if asked:
                    command += ["--time-budget", asked + "s"]
                status, message, wall, processor = bake(command, report)
                baked += 1
                if status != 0:
                    failed += 1
                    print(f"| {name} | {asked or '-'} | exit status {status}: {message.strip()} |", flush=True)
                    continue
                said = json.loads(report.read_text())
                parts = said["error"]["parts"]
                missed = asked and abs(wall / float(asked) - 1) > 0.1
                failed += bool(missed)
                split = ", ".join(percent(parts[part]["relrmse"]) for part in ("noise", "interpolation", "bands"))
                low, high = said["error"]["interval"]
                print(f"| {name} | {asked or '-'} | {wall:.1f} | {processor / arguments.threads:.1f} "
                      f"| {said['probes']['valid'] + said['probes']['moved']} "
                      f"| {percent(said['error']['relrmse'])} ({percent(low)} to {percent(high)}) | {split} "
                      f"| {'missed' if missed else ''} |", flush=True)
                if arguments.stages:
                    stages = {}
                    for stage in said["stages"]:
                        seconds, rays = stages.get(stage["name"], (0, 0))
                        stages[stage["name"]] = (seconds + stage["seconds"], rays + stage["rays"])
                    print("    " + ", ".join(f"{stage} {seconds:.1f} s {rays / 1e6:.1f} Mrays"
                                             for stage, (seconds, rays) in stages.items()), flush=True)
    if baked == 0:
        print(f"no level matches \"{arguments.match}\"")
        return 1
    print(f"\n{baked} bakes, {failed} failed or missed their budget by more than a tenth")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

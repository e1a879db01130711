#!/usr/bin/env python3
"""Bakes a level with `--report` and opens the page in headless Chromium.

    report_page_test.py --programs build/release/bin --schema tools/report.schema.json LEVEL.glb [level-bake's options]

Fails on a console message, a request that leaves the page, a plot without data or without its table, and on a page wider
than a phone's screen. With --pictures DIR it leaves screenshots (wide and phone, light and dark) and a PDF there. Exit
status 77, which ctest shows as skipped, where there is no Chromium.
"""

import argparse
import base64
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

SKIP = 77
PHONE = (390, 844)
DESK = (1280, 900)

# Every plot and picture, what it shows of data, and whether that has an extent and lies within its frame; every table.
LOOK = """
(() => {
  const inside = (box, frame) => box.left >= frame.left - 1 && box.right <= frame.right + 1 &&
                                 box.top >= frame.top - 1 && box.bottom <= frame.bottom + 1;
  const drawing = (svg) => {
    const frame = svg.getBoundingClientRect();
    const marks = [...svg.querySelectorAll('.mark')].map((mark) => mark.getBoundingClientRect());
    return {label: svg.getAttribute('aria-label'), marks: marks.length,
            bad: marks.filter((box) => !(box.width > 0 && box.height > 0 && inside(box, frame))).length,
            nonsense: /NaN|Infinity|\\bnan\\b|\\binf\\b/.test(svg.outerHTML.replace(/href="[^"]*"/g, ''))};
  };
  return {
    figures: [...document.querySelectorAll('figure.data')].map((figure) => ({
      title: figure.querySelector('h3').textContent, drawings: [...figure.querySelectorAll('svg')].map(drawing),
      rows: figure.querySelectorAll('details tbody tr').length})),
    slices: [...document.querySelectorAll('svg.slice')].map(drawing),
    images: [...document.querySelectorAll('svg.slice image')].map((image) => image.getAttribute('href')),
    width: document.documentElement.scrollWidth,
    resources: performance.getEntriesByType('resource').map((entry) => entry.name),
  };
})()
"""
DECODED = """
Promise.all(%s.map((source) => new Promise((done) => {
  const image = new Image();
  image.onload = () => done(image.naturalWidth * image.naturalHeight);
  image.onerror = () => done(0);
  image.src = source;
})))
"""


class Browser:
    """Chromium's DevTools protocol over a pipe: null-terminated JSON on descriptors 3 and 4."""

    def __init__(self, program, profile):
        to_browser, self.write_end = os.pipe()
        self.read_end, from_browser = os.pipe()

        def place_descriptors():
            # By way of high numbers, in case that a pipe has one of 3 and 4 already.
            read, write = os.dup2(to_browser, 103), os.dup2(from_browser, 104)
            os.dup2(read, 3)
            os.dup2(write, 4)

        self.process = subprocess.Popen(
            [program, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--hide-scrollbars",
             "--remote-debugging-pipe", f"--user-data-dir={profile}", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            preexec_fn=place_descriptors, close_fds=False)
        os.close(to_browser)
        os.close(from_browser)
        self.buffer = b""
        self.events = []
        self.calls = 0
        self.session = None
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Network", "Log", "Runtime", "Page"):
            self.call(domain + ".enable")

    def receive(self):
        while b"\0" not in self.buffer:
            more = os.read(self.read_end, 1 << 16)
            if not more:
                sys.exit("Chromium ended unexpectedly")
            self.buffer += more
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def call(self, method, **parameters):
        self.calls += 1
        message = {"id": self.calls, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        data = json.dumps(message).encode() + b"\0"
        while data:
            data = data[os.write(self.write_end, data):]
        while True:
            answer = self.receive()
            if answer.get("id") == self.calls:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']}")
                return answer["result"]
            self.events.append(answer)

    def open(self, page):
        self.call("Page.navigate", url=page.as_uri())
        while not any(event.get("method") == "Page.loadEventFired" for event in self.events):
            self.events.append(self.receive())

    def screen(self, size, dark=False):
        self.call("Emulation.setDeviceMetricsOverride", width=size[0], height=size[1], deviceScaleFactor=1,
                  mobile=size == PHONE)
        self.call("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    def evaluate(self, script):
        answer = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            sys.exit(f"the page could not be looked at: {answer['exceptionDetails']}")
        return answer["result"]["value"]

    def close(self):
        self.session = None
        self.call("Browser.close")
        self.process.wait(timeout=20)


def complaints(browser, page):
    """What the browser had to say, and what it asked for besides the page."""
    for event in browser.events:
        method, parameters = event.get("method"), event.get("params", {})
        if method == "Runtime.consoleAPICalled":
            yield f"console: {parameters['args']}"
        elif method == "Runtime.exceptionThrown":
            yield f"exception: {parameters['exceptionDetails']}"
        elif method == "Log.entryAdded":
            yield f"{parameters['entry']['level']}: {parameters['entry']['text']}"
        elif method == "Network.requestWillBeSent":
            url = parameters["request"]["url"]
            if url != page.as_uri() and not url.startswith("data:"):
                yield f"request: {url}"
        elif method == "Network.loadingFailed":
            yield f"not loaded: {parameters.get('errorText')} {parameters.get('blockedReason', '')}"


def check_page(browser, page, report):
    failures = []

    def that(holds, text):
        if not holds:
            failures.append(text)

    browser.screen(PHONE)
    browser.open(page)
    seen = browser.evaluate(LOOK)
    that(seen["width"] <= PHONE[0], f"{seen['width']} pixels wide on a screen of {PHONE[0]}")
    that(not [name for name in seen["resources"] if not name.startswith("data:")], f"loads {seen['resources']}")
    for figure in seen["figures"]:
        that(figure["rows"] > 0, f"{figure['title']}: no table")
        that(len(figure["drawings"]) == 1, f"{figure['title']}: {len(figure['drawings'])} plots")
    drawings = [drawing for figure in seen["figures"] for drawing in figure["drawings"]] + seen["slices"]
    for drawing in drawings:
        that(drawing["marks"] > 0, f"{drawing['label']}: no data")
        that(drawing["bad"] == 0, f"{drawing['label']}: {drawing['bad']} marks are empty or outside of the plot")
        that(not drawing["nonsense"], f"{drawing['label']}: not a number")
    that(all(browser.evaluate(DECODED % json.dumps(seen["images"]))), "a picture does not decode")

    counts = {drawing["label"]: drawing["marks"] for drawing in drawings}
    measured = report["error"]["relrmse"] is not None
    parts = [part for part in report["error"]["parts"].values() if part]
    expected = {"Parts of the error": len(parts) + measured, "Seconds of each stage": len(report["stages"])}
    if measured:
        expected["Error against seconds"] = len(report["curve"])
        expected["Error against bytes"] = len(report["look_ups"])
        expected["Error against look-up time"] = len(report["look_ups"]) // 2
    for label, marks in expected.items():
        that(counts.get(label) == marks, f"{label}: {counts.get(label)} marks for {marks} numbers")
    that(len(seen["slices"]) == (3 if report["grids"] else 0), f"{len(seen['slices'])} slices")
    failures += complaints(browser, page)
    return failures, len(drawings)


def take_pictures(browser, folder):
    for name, size in (("wide", DESK), ("phone", PHONE)):
        for dark in (False, True):
            browser.screen(size, dark)
            picture = browser.call("Page.captureScreenshot", captureBeyondViewport=True)
            (folder / f"{name}_{'dark' if dark else 'light'}.png").write_bytes(base64.b64decode(picture["data"]))
    pdf = browser.call("Page.printToPDF", printBackground=True, preferCSSPageSize=False)
    (folder / "print.pdf").write_bytes(base64.b64decode(pdf["data"]))


def check_schema(report, schema):
    try:
        import jsonschema
    except ImportError:
        print("schema not checked: python3-jsonschema is not installed")
        return []
    validator = jsonschema.Draft202012Validator(json.loads(schema.read_text()))
    return [f"schema: {'/'.join(map(str, error.absolute_path))}: {error.message}"
            for error in validator.iter_errors(report)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--programs", type=pathlib.Path, required=True)
    parser.add_argument("--schema", type=pathlib.Path, required=True)
    parser.add_argument("--pictures", type=pathlib.Path)
    arguments, bake = parser.parse_known_args()

    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        page = folder / "report <of> & 'a' \"bake\".html"
        command = [str(arguments.programs.absolute() / "level-bake"), *bake, "-o", str(folder / "volume.exr"), "--report",
                   str(page), "--report-json", str(folder / "report.json"), "--quiet"]
        result = subprocess.run(command, stdin=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        if result.returncode != 0:
            sys.exit(f"{' '.join(command)}\n{result.stderr}")
        report = json.loads((folder / "report.json").read_text())
        failures = check_schema(report, arguments.schema)
        drawings = 0
        if chromium:
            browser = Browser(chromium, folder / "profile")
            try:
                more, drawings = check_page(browser, page, report)
                failures += more
                if arguments.pictures:
                    arguments.pictures.mkdir(parents=True, exist_ok=True)
                    take_pictures(browser, arguments.pictures)
                    shutil.copy(page, arguments.pictures / "report.html")
                browser.close()
            finally:
                browser.process.kill()
    for failure in failures:
        print("FAIL", failure)
    if failures:
        sys.exit(1)
    if not chromium:
        print("skipped: no chromium (Debian's package of that name)")
        sys.exit(SKIP)
    print(f"{drawings} plots and pictures have their data; nothing was asked for, nothing complained of")


if __name__ == "__main__":
    main()

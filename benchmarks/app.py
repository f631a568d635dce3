"""Latency of the app, from an input to pixels, and its size.

    python benchmarks/app.py [--chromium PATH] [--samples 40] [--memory SECONDS]

The script requires an installed Chromium and the Python package playwright.  "To pixels" is the
time from the event of a control to the task after the next frame; the browser has no screen.  The
server and the page share the processors with this script, so the load of the machine is printed,
too.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import psutil
from playwright.sync_api import Browser, Page, sync_playwright

from hertzchain.app.requests import Request
from hertzchain.app.results import results
from hertzchain.app.serve import RunningServer

SETTLED = "body[data-settled=yes]"
# One change of the rate, as from a slider that is dragged.
CHANGE = """([rate]) => {
  const box = document.getElementById("c-chain.rate");
  box.value = rate;
  box.dispatchEvent(new Event("input", {bubbles: true}));
}"""
DRAG = """seconds => new Promise(done => {
  const box = document.getElementById("c-chain.rate"), low = Number(box.value), began = performance.now();
  const step = () => {
    const t = performance.now() - began;
    box.value = (low * (1 + 0.4 * Math.sin(t / 500))).toPrecision(4);
    box.dispatchEvent(new Event("input", {bubbles: true}));
    if (t < 1000 * seconds) setTimeout(step, 1000 / 60); else done(began);
  };
  step();
})"""  # noqa: E501
FRAMES = """seconds => new Promise(done => {
  const began = performance.now(), own = requestAnimationFrame, drawn = []; let count = 0;
  window.requestAnimationFrame = draw => own(now => {
    const start = performance.now();
    draw(now);
    drawn.push(performance.now() - start);
  });
  const step = now => {
    count += 1;
    if (now - began < 1000 * seconds) own(step);
    else done([count / seconds, drawn]);
  };
  own(step);
})"""


def spread(values: list[float]) -> str:
    """Median, with the smallest and the largest value."""
    if not values:
        return "no answer"
    return f"{statistics.median(values):.0f} [{min(values):.0f} .. {max(values):.0f}] ms"


def open_page(browser: Browser, server: RunningServer, beads: int, *, still: bool = True) -> Page:
    """A tab with a backward-exponential taper."""
    motion = "reduce" if still else "no-preference"
    context = browser.new_context(viewport={"width": 1600, "height": 1000}, reduced_motion=motion)
    page = context.new_page()
    page.goto(server.address)
    rate = 0.05 if beads <= 100 else 0.005
    page.goto(
        f"{server.address.partition('?')[0]}#taper=backward-exponential&rate={rate}&beads={beads}"
    )
    page.reload()
    page.wait_for_selector(SETTLED, timeout=300_000)
    return page


def to_pixels(page: Page, samples: int) -> tuple[list[float], list[float]]:
    """Times from single changes to the pixels of the pulse and of the map, in drafts."""
    rate = float(page.input_value("[id='c-chain.rate']"))
    pulses, maps = [], []
    for sample in range(samples):
        page.evaluate("hertzchain.answers.length = 0")
        page.evaluate(CHANGE, [rate * (1 + 0.01 * (sample % 7 - 3))])
        page.wait_for_timeout(350 if rate > 0.01 else 700)
        answers = page.evaluate("hertzchain.answers")
        for found, part in ((pulses, "pulse"), (maps, "run")):
            found += [a["shown"] - a["input"] for a in answers if a["part"] == part and a["draft"]][
                :1
            ]
    page.wait_for_selector(SETTLED)
    return pulses, maps


def drag(page: Page, seconds: float = 2.0) -> float:
    """Updates of the pulse per second during a steady drag."""
    page.evaluate("hertzchain.answers.length = 0")
    page.evaluate(DRAG, seconds)
    answers = page.evaluate("hertzchain.answers")
    page.wait_for_selector(SETTLED)
    return sum(a["part"] == "pulse" for a in answers) / seconds


def server_only(beads: int, samples: int) -> str:
    """Time of only the server for a pulse, and for the draft of a run."""
    pulses, runs = [], []
    for sample in range(samples):
        rate = (0.05 if beads <= 100 else 0.005) * (1 + 0.01 * (sample % 7))
        table = {"taper": "backward-exponential", "rate": rate, "beads": beads}
        request = Request("s", "A", 1, {"chain": table}, 160, 1e-6, draft=True)
        began = time.perf_counter()
        for part in results(request, lambda: False):
            part.pack()
            found = {"pulse": pulses, "run": runs}.get(part.header["part"])
            if found is not None:
                found.append(1e3 * (time.perf_counter() - began))
    return f"pulse {spread(pulses)}, map {spread(runs)}"


def cancel() -> float:
    """Milliseconds until a long run has stopped, after it was requested to."""
    stop = threading.Event()
    chain = {"taper": "uniform", "beads": 1500, "right_wall": {}}
    request = Request("s", "A", 1, {"chain": chain}, 320, 1e-13)
    ended = []

    def work() -> None:
        parts = [part.header["part"] for part in results(request, stop.is_set)]
        assert parts[-1] == "cancelled"
        ended.append(time.perf_counter())

    thread = threading.Thread(target=work)
    thread.start()
    time.sleep(1.0)
    began = time.perf_counter()
    stop.set()
    thread.join()
    return 1e3 * (ended[0] - began)


def start_up(browser: Browser) -> tuple[float, float, float, int, int]:
    """Milliseconds from the command to paint, theories and pulse; requests and bytes."""
    began = time.time()
    command = [sys.executable, "-m", "hertzchain", "app", "--no-open", "--port", "0"]
    quiet = {"stderr": subprocess.DEVNULL, "text": True}
    with subprocess.Popen(command, stdout=subprocess.PIPE, **quiet) as server:
        assert server.stdout is not None
        address = server.stdout.readline().strip()
        page = browser.new_page()
        sizes: list[int] = []
        page.on("response", lambda each: sizes.append(int(each.headers.get("content-length", "0"))))
        page.goto(address)
        page.wait_for_selector(SETTLED, timeout=300_000)
        origin = page.evaluate("performance.timeOrigin")
        paint = page.evaluate("performance.getEntriesByType('paint').at(-1).startTime")
        answers = page.evaluate("hertzchain.answers")
        shown = [
            next(a["shown"] for a in answers if a["part"] == part) for part in ("beads", "pulse")
        ]
        page.close()
        server.terminate()
    first = origin - 1e3 * began
    return first + paint, first + shown[0], first + shown[1], len(sizes), sum(sizes)


def memory(browser: Browser, server: RunningServer, seconds: float) -> str:
    """Memory of this process, which includes the server, during drags in eight tabs."""
    pages = [open_page(browser, server, 100) for _ in range(8)]
    process, sizes = psutil.Process(), []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for page in pages:
            page.evaluate(f"void ({DRAG})(2)")
        time.sleep(2.5)
        sizes.append(process.memory_info().rss / 2**20)
    for page in pages:
        page.context.close()
    quarter = max(1, len(sizes) // 4)
    first, last = statistics.mean(sizes[:quarter]), statistics.mean(sizes[-quarter:])
    return f"{first:.0f} MiB at first, {last:.0f} MiB at the end, after {seconds:.0f} s"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--chromium", default=shutil.which("chromium"))
    parser.add_argument("--samples", type=int, default=40)
    parser.add_argument("--memory", type=float, default=20.0)
    given = parser.parse_args()
    rows: dict[str, Any] = {"load": " ".join(f"{each:.1f}" for each in os.getloadavg())}
    server = RunningServer(0)
    server.start()
    while server.app.warm_up.pending():
        time.sleep(0.1)
    for beads in (100, 1000):
        rows[f"server alone, N = {beads}"] = server_only(beads, given.samples)
    rows["cancel"] = spread([cancel() for _ in range(5)])
    with sync_playwright() as playwright:
        options = [] if os.geteuid() else ["--no-sandbox"]
        browser = playwright.chromium.launch(executable_path=given.chromium, args=options)
        for beads in (100, 1000):
            page = open_page(browser, server, beads)
            pulses, maps = to_pixels(page, given.samples)
            rows[f"slider to pixels, N = {beads}"] = spread(pulses)
            rows[f"draft of the map, N = {beads}"] = spread(maps)
            rows[f"updates per second in a drag, N = {beads}"] = f"{drag(page):.0f}"
            page.context.close()
        page = open_page(browser, server, 1000, still=False)
        rate, frames = page.evaluate(FRAMES, 3)
        rows["animation, N = 1000"] = (
            f"{rate:.0f} frames/s, draw {statistics.median(frames):.1f} ms"
        )
        page.context.close()
        rows["memory of eight tabs"] = memory(browser, server, given.memory)
        paint, theory, pulse, requests, size = start_up(browser)
        rows["command to first paint, theories, pulse"] = (
            f"{paint:.0f}, {theory:.0f}, {pulse:.0f} ms"
        )
        rows["page"] = f"{requests} requests, {size / 1000:.0f} kB"
        browser.close()
    server.stop()
    rows["load at the end"] = " ".join(f"{each:.1f}" for each in os.getloadavg())
    for name, value in rows.items():
        print(f"{name:42} {value}")
    Path("benchmark").mkdir(exist_ok=True)
    Path("benchmark/app.json").write_text(json.dumps(rows, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()

"""Compare the charts of the app with uPlot and Observable Plot: size, and time of an update.

    npm install --prefix FOLDER uplot @observablehq/plot d3
    python benchmarks/chart_libraries.py FOLDER/node_modules

An update draws four curves again, as a drag does for each chart, and waits for the layout.  The
three libraries are measured alternately in one page.
"""

from __future__ import annotations

import gzip
import os
import shutil
import sys
from pathlib import Path

from playwright.sync_api import Route, sync_playwright

STATIC = Path(__file__).parents[1] / "src/hertzchain/app/static"
FILES = {
    "uPlot": ["uplot/dist/uPlot.iife.min.js", "uplot/dist/uPlot.min.css"],
    "Observable Plot": ["d3/dist/d3.min.js", "@observablehq/plot/dist/plot.umd.min.js"],
}
MEASURE = """async points => {
  const { Chart } = await import("/js/chart.js");
  const host = name => document.getElementById(name), labels = ["exact", "bca", "local-rate", "modified-bca"];
  const x = Float64Array.from({ length: points }, (_, k) => k + 1);
  const curves = seed => labels.map((_, n) => x.map(k => Math.exp(-k / points * (n + 1 + 0.1 * Math.sin(seed)))));
  const own = new Chart(host("own"), () => {});
  const u = new uPlot({ width: 400, height: 220, series: [{}, ...labels.map(label => ({ label, stroke: "black" }))], scales: { x: { time: false } } }, [x, ...curves(0)], host("u"));
  const draw = {
    "own SVG": y => own.draw(labels.map((name, n) => ({ name, label: name, x, y: y[n] })), { xLabel: "k", yLabel: "v" }, ""),
    "uPlot": y => u.setData([x, ...y]),
    "Observable Plot": y => host("plot").replaceChildren(Plot.plot({ width: 400, height: 220, marks: labels.map((_, n) => Plot.lineY(y[n], { x: (_, k) => k + 1 })) })),
  };
  const times = Object.fromEntries(Object.keys(draw).map(name => [name, []]));
  for (let round = 0; round < 60; round++) {
    const y = curves(round);
    for (const [name, action] of Object.entries(draw)) {
      const began = performance.now();
      action(y);
      await null;  // uPlot draws in a microtask.
      document.body.getBoundingClientRect();
      times[name].push(performance.now() - began);
    }
    if (round % 10 === 9) await new Promise(requestAnimationFrame);
  }
  return Object.entries(times).map(([name, each]) => [name, ...[0.5, 0].map(q => each.slice(10).sort((a, b) => a - b)[(50 * q) | 0])]);
}"""  # noqa: E501
PAGE = """<!doctype html>
<link rel=stylesheet href=/app.css><link rel=stylesheet href=/uPlot.min.css>
<div id=own style="width:400px;height:220px" class=plot></div>
<div id=u></div><div id=plot></div>
<script src=/uPlot.iife.min.js></script><script src=/d3.min.js></script>
<script src=/plot.umd.min.js></script>"""


def main(modules: Path) -> None:
    """Print sizes and times."""
    libraries = {Path(each).name: modules / each for files in FILES.values() for each in files}
    sizes = {name: [modules / each for each in files] for name, files in FILES.items()}
    sizes["own SVG"] = [STATIC / "js/chart.js"]
    for name, files in sizes.items():
        raw = [file.read_bytes() for file in files]
        packed = sum(len(gzip.compress(each)) for each in raw)
        print(f"{name:18} {sum(map(len, raw)) / 1000:6.0f} kB, {packed / 1000:5.0f} kB compressed")

    def answer(route: Route) -> None:
        name = route.request.url.removeprefix("http://page.test/")
        if not name:
            route.fulfill(body=PAGE, content_type="text/html")
        else:
            route.fulfill(path=libraries.get(name, STATIC / name))

    with sync_playwright() as playwright:
        options = [] if os.geteuid() else ["--no-sandbox"]
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=options)
        page = browser.new_page()
        page.route("**/*", answer)
        page.goto("http://page.test/")
        for points in (100, 1000):
            for name, median, best in page.evaluate(MEASURE, points):
                print(f"{name:18} {points:5} points: median {median:.2f} ms, best {best:.2f} ms")
        browser.close()


if __name__ == "__main__":
    main(Path(sys.argv[1]))

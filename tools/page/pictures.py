"""Draw the pictures of the app and of a notebook in the documentation: docs/app/*.png.

    python tools/page/pictures.py

It needs an installed Chromium and the Python package playwright.
"""

import os
import shutil
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

import hertzchain as hc
from hertzchain.app.serve import RunningServer

FOLDER = Path(__file__).parents[2] / "docs/app"
SETTLED = "body[data-settled=yes]"
# Milliseconds; new features are compiled.
TIMEOUT = 300_000
# Name, colours, width and height of the window, example of the gallery, and place of the clock.
PICTURES = (
    ("steel-balls", "light", 1440, 1000, None, 0.5),
    ("striker-and-wall", "dark", 1440, 1120, "Heavy steel striker and a wall", 0.62),
    ("materials", "light", 1440, 1150, "Steel and PTFE shock absorber", 0.4),
    ("shock-absorber", "light", 1440, 1300, "Shock absorber", 0.47),
    ("phone", "light", 400, 800, "A defect", 0.6),
)
GO_TO = """place => {
  const time = document.getElementById("time");
  time.value = 1000 * place;
  time.dispatchEvent(new Event("input"));
}"""


def draw_notebook(browser: Browser) -> None:
    """The run of docs/how-to/notebooks.md, as a cell shows it."""
    row = hc.Chain.from_materials(
        diameters="10 mm", materials="steel-52100", beads=20, right_wall=hc.Wall()
    )
    run = hc.simulate(row.struck_by(velocity="0.1 m/s"), until="1 ms", times=2001)
    page = browser.new_page(viewport={"width": 640, "height": 280}, device_scale_factor=2)
    page.set_content(f"<body style='font-family:sans-serif;margin:8px'>{run._repr_html_()}</body>")
    page.screenshot(path=FOLDER / "notebook.png", full_page=True)
    page.close()


def main() -> None:
    """Draw all pictures."""
    FOLDER.mkdir(exist_ok=True)
    server = RunningServer(0, warm_up=False)
    server.start()
    with sync_playwright() as playwright:
        options = [] if os.geteuid() else ["--no-sandbox"]
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=options)
        draw_notebook(browser)
        for name, scheme, width, height, example, place in PICTURES:
            size = {"width": width, "height": height}
            page = browser.new_page(viewport=size, color_scheme=scheme, reduced_motion="reduce")
            page.set_default_timeout(TIMEOUT)
            page.goto(server.address)
            page.wait_for_selector(SETTLED)
            if example is not None:
                page.click("#open-examples")
                page.click(f"button[aria-label='Open {example}']")
                page.wait_for_timeout(100)
                page.wait_for_selector(SETTLED)
            if name == "materials":
                page.select_option("#force-scale", "each")
            page.evaluate(GO_TO, place)
            page.wait_for_timeout(200)
            page.screenshot(path=FOLDER / f"{name}.png")
            page.close()
        browser.close()
    server.stop()


if __name__ == "__main__":
    main()

"""Check the built documentation: links, texts of images, contrast, and pages on a phone.

    python tools/check_pages.py FOLDER [--browser CHROMIUM]

Every link within the documentation must lead to an existing file and anchor, every image needs an
alternative text, no address outside may be loaded, and no signature may show internal types.  With
a Chromium, every page is also shown 400 px wide, in light and dark colours: it must not scroll
sideways, and text needs a contrast of 4.5 (3 if it is large).  The exit code is 1 if anything is
found.
"""

import argparse
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

WIDTH = 400
# Alternative texts that say nothing.
EMPTY = ("", "image", "figure", "plot")
THUMBNAIL = "_thumb.png"
# Names of types that signatures must not show; `autodoc_type_aliases` in docs/conf.py names others.
INTERNAL = ("_SupportsArray", "_NestedSequence", "TypeAliasForwardRef")
# Returns the texts whose contrast is too small, each with its ratio.
CONTRAST = """
() => {
  const canvas = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const rgba = (colour) => {
    canvas.clearRect(0, 0, 1, 1); canvas.fillStyle = colour; canvas.fillRect(0, 0, 1, 1);
    const [r, g, b, a] = canvas.getImageData(0, 0, 1, 1).data; return [r, g, b, a / 255];
  };
  const over = (top, below) => [0, 1, 2].map((i) => top[3] * top[i] + (1 - top[3]) * below[i]);
  const light = (c) => c.slice(0, 3).map((x) => x / 255)
    .map((x) => x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4)
    .reduce((sum, x, i) => sum + x * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (element) => {
    const layers = [];
    for (let e = element; e; e = e.parentElement) {
      const colour = rgba(getComputedStyle(e).backgroundColor);
      layers.push(colour);
      if (colour[3] === 1) break;
    }
    return layers.reverse().reduce((below, top) => over(top, below), [255, 255, 255]);
  };
  const found = new Map();
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim(), element = walker.currentNode.parentElement;
    const box = element.getBoundingClientRect(), style = getComputedStyle(element);
    const hidden = box.width < 2 || box.height < 2 || style.visibility === 'hidden'
      || Number(style.opacity) === 0 || element.closest('svg, .headerlink, script, style');
    if (!text || hidden || !element.checkVisibility()) continue;
    const back = behind(element), front = over(rgba(style.color), back);
    const [a, b] = [light(front), light(back)];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    const size = parseFloat(style.fontSize), bold = Number(style.fontWeight) >= 700;
    if (ratio < (size >= 24 || (bold && size >= 18.66) ? 3 : 4.5) - 0.005) {
      const key = element.className + ' ' + style.color;
      if (!found.has(key)) found.set(key, text.slice(0, 30) + ' (' + ratio.toFixed(2) + ')');
    }
  }
  return [...found.values()];
}
"""


class Page(HTMLParser):
    """Links, anchors, images and loaded files of a page."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()
        self.texts: list[tuple[str, str | None]] = []
        self.loaded: list[str] = []
        self.feed(path.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what one element refers to."""
        given = dict(attrs)
        self.anchors.update(name for name in (given.get("id"), given.get("name")) if name)
        if tag == "a" and given.get("href"):
            self.links.append(given["href"] or "")
        if tag == "img":
            self.texts.append((given.get("src") or "", given.get("alt")))
        if tag in ("img", "script", "source", "iframe") and given.get("src"):
            self.loaded.append(given["src"] or "")
        if tag == "link" and given.get("rel") in ("stylesheet", "icon", "preload"):
            self.loaded.append(given.get("href") or "")


def check_files(folder: Path) -> Iterator[str]:
    """Problems with links, images and loaded files."""
    pages = {path: Page(path) for path in sorted(folder.rglob("*.html"))}
    for path, page in pages.items():
        here = path.relative_to(folder)
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                yield f"{here}: link to {link}, which does not exist"
            elif parts.fragment and target in pages:
                anchor = unquote(parts.fragment)
                if anchor not in pages[target].anchors:
                    yield f"{here}: link to {link}, but there is no such anchor"
        for source, alternative in page.texts:
            # The title is next to the thumbnail of a notebook, which needs no text.
            if alternative is None or (
                alternative.strip().lower() in EMPTY and THUMBNAIL not in source
            ):
                yield f"{here}: image {source} has no alternative text"
        text = path.read_text("utf-8")
        for name in INTERNAL:
            if name in text:
                yield f"{here}: a signature shows {name}"
        for source in page.loaded:
            if urlsplit(source).netloc:
                yield f"{here}: {source} is loaded from another host"


def check_in_browser(folder: Path, chromium: str) -> Iterator[str]:
    """Problems with contrast and width on a phone."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for scheme in ("light", "dark"):
            view = browser.new_page(
                viewport={"width": WIDTH, "height": 800},
                color_scheme=scheme,  # type: ignore[arg-type]
            )
            for path in sorted(folder.rglob("*.html")):
                here = path.relative_to(folder)
                view.goto(path.as_uri())
                wide = view.evaluate("document.documentElement.scrollWidth")
                if wide > WIDTH:
                    yield f"{here}: {wide} px wide on a screen of {WIDTH} px"
                for text in view.evaluate(CONTRAST):
                    yield f"{here}, {scheme}: contrast of {text}"
            view.close()
        browser.close()


def main(arguments: list[str] | None = None) -> int:
    """Print all problems and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path, help="folder of the HTML files")
    parser.add_argument("--browser", metavar="CHROMIUM", help="program for the checks in a browser")
    options = parser.parse_args(arguments)
    folder = options.folder.resolve()
    found = list(check_files(folder))
    if options.browser:
        found += check_in_browser(folder, options.browser)
    for problem in found:
        print(problem)
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())

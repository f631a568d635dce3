"""HTML representation of a chain: its beads to scale, and numbers that describe it."""

from __future__ import annotations

from typing import Final

import numpy as np

from ..chain.chain import Chain
from ..chain.chain_words import cap_in_words, described_strikers
from ..chain.drawn_bodies import (
    body_centres,
    flat_bodies,
    half_heights,
    half_widths,
    known_radii,
)  # fmt: skip
from ..chain.hertz_range import ESTIMATED, UNKNOWN_YIELD, HertzRange
from ..chain.hertz_ratios import MAX_SPEED_RATIO
from ..chain.laws.base import Loss
from ..chain.materials import RIGID, Catalogue, Material
from ..chain.scales import Scales
from ..chain.walls import Wall
from ..collision import Array
from .drawing import (
    COLOURS,
    WIDTH,
    engineering,
    legend,
    note,
    numbers,
    page,
    sentence,
    svg,
    table,
)

# Beads beyond which the outline of the chain is drawn instead of circles.
MAX_CIRCLES: Final = 240
MAX_HEIGHT: Final = 130.0
# Thickness of a wall in the figure, and the space at both ends.
WALL, MARGIN = 7.0, 12.0


def chain_html(chain: Chain) -> str:
    """Figure and numbers of a chain."""
    parts = [_drawing(chain)]
    kinds = [*dict.fromkeys(each.name for each in chain.materials or ())]
    if 1 < len(kinds) <= len(COLOURS) and chain.beads <= MAX_CIRCLES:
        parts.append(legend(zip(kinds, COLOURS, strict=False)))
    parts.append(numbers(_numbers(chain)))
    if chain.units == "scaled":
        first = "the first radius" if chain.radii[chain.strikers] == 1.0 else "a radius"
        parts.append(
            note(
                f"Scaled variables: lengths are in units of {first}, velocities in units of the "
                "impact velocity."
            )
        )
    return page("Chain", chain.description, *parts)


def _numbers(chain: Chain) -> dict[str, str]:
    units = chain.units

    def range_of(values: Array, unit: str) -> str:
        low, high = float(values.min()), float(values.max())
        ends = [engineering(low, unit, units)]
        if high > low * (1.0 + 1e-12):
            ends.append(engineering(high, unit, units))
        return " .. ".join(ends)

    found = {"beads": _count(chain), "radii": range_of(known_radii(chain), "m"),
             "total mass": engineering(1e3 * chain.masses.sum(), "g") if units == "SI"
             else f"{chain.masses.sum():.4g}"}  # fmt: skip
    if chain.taper is not None:
        found["taper"] = f"{chain.taper}, {chain.rate:g}"
    struck = np.flatnonzero(chain.velocities)
    if len(struck):
        fastest = float(chain.velocities[struck[np.argmax(np.abs(chain.velocities[struck]))]])
        which = f"bead {struck[0] + 1}" if len(struck) == 1 else f"{len(struck)} beads"
        found["struck"] = f"{which} at velocity {engineering(fastest, 'm/s', units)}"
    exponents = dict.fromkeys(f"{each:g}" for each in np.atleast_1d(chain.exponents))
    if [*exponents] != ["1.5"]:
        found["exponent"] = ", ".join(exponents)
    if not chain.lossless:
        laws = dict.fromkeys(type(each).__name__ for each in chain.contact_losses)
        found["loss"] = ", ".join(laws)
    if chain.drive is not None:
        found["drive"] = type(chain.drive).__name__
    if chain.precompression > 0.0:
        found["precompression"] = engineering(chain.precompression, "N", units)
    return found


def _count(chain: Chain) -> str:
    """Number of beads, of which strikers are stated separately."""
    others = " and ".join(filter(None, (described_strikers(chain), cap_in_words(chain))))
    balls = f"{len(chain.radii[chain._balls])}"
    return f"{balls}, and {others}" if others else balls


def _drawing(chain: Chain) -> str:
    """Beads, strikers in outline, and walls; to scale."""
    places, widths, heights = body_centres(chain), half_widths(chain), half_heights(chain)
    length, largest = places[-1] + widths[-1], float(heights.max())
    scale = min((WIDTH - 2.0 * MARGIN) / length, 0.5 * MAX_HEIGHT / largest)
    # A long chain would be too thin to see, so its thickness is not to scale.
    thick = max(scale, 5.0 / largest)
    height = max(2.0 * thick * largest, 20.0) + 8.0
    begin = 0.5 * (WIDTH - scale * length)
    centres, middle = begin + scale * places, 0.5 * height
    if chain.beads <= MAX_CIRCLES:
        content = _shapes(chain, centres, (scale * widths, scale * heights), middle)
    else:
        content = _outline(centres, thick * heights, middle)
    for wall, at, outwards in (
        (chain.left_wall, begin, -1.0), (chain.right_wall, begin + scale * length, 1.0),
    ):  # fmt: skip
        if wall is not None:
            gap = 4.0 if wall.gap > 0.0 else 0.0
            left = at + outwards * gap - (WALL if outwards < 0.0 else 0.0)
            content += (
                f'<rect x="{left:.1f}" y="2" width="{WALL:g}" height="{height - 4:.1f}" '
                'fill="currentColor" opacity="0.45"/>'
            )
    return svg(content, height, f"the beads of the chain: {chain.description}")


def _shapes(chain: Chain, centres: Array, sizes: tuple[Array, Array], middle: float) -> str:
    """Circles, and plates for flat bodies; strikers in outline."""
    kinds = [*dict.fromkeys(chain.materials or (None,))]
    colours = {kind: COLOURS[i % len(COLOURS)] for i, kind in enumerate(kinds)}
    found = []
    flat = flat_bodies(chain)
    for k, (x, r, h) in enumerate(zip(centres, *sizes, strict=True)):
        colour = colours[chain.materials[k] if chain.materials else None]
        fill = "none" if k < chain.strikers else colour
        style = f'fill="{fill}" fill-opacity="0.55" stroke="{colour}"/>'
        plate = f'x="{x - r:.1f}" y="{middle - h:.1f}" width="{2 * r:.2f}" height="{2 * h:.2f}"'
        circle = f'cx="{x:.1f}" cy="{middle:.1f}" r="{max(r - 0.4, 0.4):.2f}"'
        found.append(f"<rect {plate} {style}" if flat[k] else f"<circle {circle} {style}")
    return "".join(found)


def _outline(centres: Array, radii: Array, middle: float) -> str:
    """The radii along the chain, as a band: the largest of each column."""
    columns = np.array_split(np.arange(len(centres)), min(len(centres), 300))
    x = [float(centres[column].mean()) for column in columns]
    r = [float(radii[column].max()) for column in columns]
    upper = "L".join(f"{a:.1f} {middle - b:.1f}" for a, b in zip(x, r, strict=True))
    lower = "L".join(f"{a:.1f} {middle + b:.1f}" for a, b in zip(x[::-1], r[::-1], strict=True))
    colour = COLOURS[0]
    return f'<path d="M{upper}L{lower}Z" fill="{colour}" fill-opacity="0.55" stroke="{colour}"/>'


def material_html(material: Material) -> str:
    """Numbers of a material with their source."""
    elastic = np.isfinite(material.young)
    strength = material.yield_strength
    found = {
        "density": f"{material.density:g} kg/m^3",
        "Young's modulus": engineering(material.young, "Pa") if elastic else "rigid",
        "Poisson's ratio": f"{material.poisson:g}",
        "yield strength": "" if strength is None else engineering(strength, "Pa"),
        "speed of sound in a bar": engineering(material.sound_speed, "m/s") if elastic else "",
    }
    source = [note(f"Source: {material.source}.")] if material.source else []
    known = {name: value for name, value in found.items() if value}
    return page("Material", material.name, numbers(known), *source)


def catalogue_html(materials: Catalogue) -> str:
    """A table of materials."""
    header, *rows = materials._rows()
    return page("Materials", "", table(header, rows, numeric=True))


def wall_html(wall: Wall) -> str:
    """Material, stiffness, gap, exponent and loss of a wall."""
    real = "gap" in wall.with_units or wall.material not in (None, RIGID)
    kind = "that of the bead" if wall.material is None else wall.material.name
    found = {
        "material": kind if wall.stiffness is None else "",
        "stiffness": wall._stiffness_in_words(),
        "gap": engineering(wall.gap, "m", "SI" if real else "scaled") if wall.gap else "0",
        "exponent": "that of the chain" if wall.exponent is None else f"{wall.exponent:g}",
        "loss": "that of the chain" if wall.loss is None else repr(wall.loss),
    }
    return page("Wall", "", numbers({name: value for name, value in found.items() if value}))


def loss_html(law: Loss) -> str:
    """Parameters of a law with their units and meaning."""
    rows = []
    for name, about in law.parameters().items():
        value, unit = getattr(law, name), law._unit(name) or ""
        if value is None:
            continue
        if about.boolean:
            shown = "yes" if value else "no"
        elif about.dimension and name in law.with_units:
            shown = engineering(value, unit)
        else:
            shown = f"{value:g}"
            if about.dimension:
                shown += f" {unit} (scaled: in its unit of {about.dimension})"
        rows.append((name, shown, about.description))
    doc = (type(law).__doc__ or "").partition("\n")[0]
    parts = [table(("parameter", "value", "meaning"), rows)] if rows else []
    return page(type(law).__name__, law.words or law.name, note(doc), *parts)


def scales_html(scales: Scales) -> str:
    """The unit of each scaled variable, in SI."""
    lengths = ("radius", scales.radius), ("displacement, overlap, gap", scales.length)
    rows = [[name, engineering(value, "m")] for name, value in lengths]
    rows += [
        ["mass", engineering(1e3 * scales.mass, "g")],
        ["velocity", engineering(scales.velocity, "m/s")],
        ["time", engineering(scales.time, "s")],
        ["force", engineering(scales.force, "N")],
        ["momentum", engineering(scales.momentum, "N s")],
        ["energy", engineering(scales.energy, "J")],
    ]
    return page("Scales", f"p = {scales.exponent:g}", table(("variable", "unit"), rows))


def _yield_of_law(found: HertzRange) -> list[str]:
    """Largest pressure, contact and limit, of contacts whose law describes yield."""
    at = int(np.nanargmax(found.law_yield_ratio))
    return [f"{found.law_yield_ratio[at]:.3g}", f"contact {at}", "1"]


def hertz_range_html(found: HertzRange) -> str:
    """The largest of each ratio with its limit, and what is exceeded."""
    overlap, pressure = found._most_squeezed, found._most_loaded
    limit = found.overlap_limit[overlap]
    rows = (
        ("overlap / radius", found.overlap_ratio[overlap], f"contact {overlap}", limit),
        ("pressure / yield", found.yield_ratio[pressure], f"contact {pressure}", 1.0),
        ("speed / sound", found.speed_ratio, "time 0", MAX_SPEED_RATIO),
    )
    cells = [
        [name, f"{value:.3g}", place, f"{limit:g}", "exceeded" if value > limit else "within"]
        if value == value
        else [name, *_yield_of_law(found), "law of the contact"]
        if name == "pressure / yield" and not np.isnan(found.law_yield_ratio).all()
        else [name, "unknown", "-", f"{limit:g}", UNKNOWN_YIELD]
        for name, value, place, limit in rows
    ]
    texts = [*found.violations, *([ESTIMATED] if found.estimated else [])]
    notes = [note(sentence(text)) for text in texts]
    return page(
        "HertzRange", f"{len(found.overlap_ratio)} contacts, numbered from the left wall (0)",
        table(("ratio", "largest", "at", "limit", ""), cells), *notes,
    )  # fmt: skip

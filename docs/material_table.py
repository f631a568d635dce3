"""The table of materials in the reference, from the catalogue."""

import hertzchain as hc


def material_table() -> str:
    """Return a table in Markdown of all materials with the sources of their values."""
    lines = ["| material | density [kg/m³] | E [GPa] | ν | yields at [MPa] | source |",
             "|---|---|---|---|---|---|"]  # fmt: skip
    for name, each in hc.catalogue().items():
        strength = "" if each.yield_strength is None else f"{each.yield_strength / 1e6:g}"
        source = each.source.replace("kg/m^3", "kg/m³").replace("kN/m^3", "kN/m³")
        numbers = f"{each.density:g} | {each.young / 1e9:g} | {each.poisson:g} | {strength}"
        lines.append(f"| {name} | {numbers} | {source} |")
    return "\n".join(lines) + "\n"

"""Messages of the library in the words of the page."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from ..chain.chain import Chain
from ..chain.description import impact_in_words, length_in_words, sizes_in_words
from ..collision import Array
from ..notebook.drawing import engineering
from ..plotting.methods import name_of

# Python expressions in messages, and the choice on the page instead.
WORDINGS: Final = (
    # The loss of the page is that of its simulations.
    (r"\buse simulate with loss=", "use loss="),
    # The page has no losses of walls.
    (r" or use loss=ElasticPlastic\(.*\) and loss=Elastic\(\) for.*", ""),
    (r"\buse loss=ElasticPlastic\(factor=([\d.]+)\)", r"choose \1 as the factor of the loss"),
    (r"\buse loss=ElasticPlastic\(\)", "choose the loss elastic-plastic"),
    (r"\buse loss=ElasticPlastic\(yield_overlap=\.\.\.\)",
     "choose the loss elastic-plastic with a yield overlap"),
    (r",? or until\b", ""),
    # Limits of polymers are cautious: exceeding them need not have this effect.
    # All forces of the page are those of a simulation.
    (r"^simulation: ", ""),
    (r"^pressure / yield is (?!.*cautious for polymers)",
     "contacts would be dented, and forces may be lower: pressure / yield is "),
    (r"\bgive materials, such as materials='([^']*)'", r"choose a material, such as \1"),
    (r"^\[chain\] has velocity and also velocities: omit one",
     "there are an impact velocity and a list of velocities: empty one of the two controls"),
    (r"\bgive first_diameter and last_diameter", "choose 'end diameters'"),
    (r"\bgive (left|right)_wall, or held_by=", r"add a \1 wall, or choose held_by="),
    (r", such as (?:right_wall=)?Wall\('5 kN/mm', exponent=1\)(?= for a load cell|, but)",
     ", such as 5 kN/mm with exponent 1"),
    (r"; set the wall before the cap, or give the mass$", ""),
    (r"\bheld_by='(\w+)'", r"'held by \1'"),
    (r"^modified_bca does", "the modified BCA does"),
    (r"^effective_chain does", "the effective chain does"),
    (r"^propagate does", "the simulation of the pulse does"),
    (r"(?<=\d )u(?=[JNms]\b)", "µ"),
    (r"\b(first|last|cell|mass)_(diameters?|radius|ratio)\b", r"\1 \2"),
    (r"^\[chain\] has no taper\b.*", "enter the size of the beads, or undo the last change"),
    (r"^\[chain\] has no (beads|cells), which goes with .*", r"enter the number of \1"),
    (r"^\[chain\] has no (\w+), which goes with .*", r"enter the \1"),
    (r"^\[chain\] has taper = .* but no rate, its parameter (\w+)",
     r"enter the rate \1 of the taper"),
    (r"^Chain\.tapered needs a taper and its rate .*", "enter the size of the last bead"),
    (r", or Chain\.from_radii for (?:any|arbitrary) radii", ", or choose 'a list of radii'"),
    (r"; Chain\.from_materials builds one from radii and materials", ""),
    (r"\buse Wall\.rigid\(\)", "choose 'rigid'"),
    (r"; give Wall\(stiffness=\.\.\.\)", "; enter its stiffness"),
    (r", or set with_contacts\(.*\) for the chain of exponent 1\.5",
     ", or empty the exponent and use Shapes of contacts"),
    (r"\[chain\.(left|right)_wall\]", r"the \1 wall"),
    (r"\[chain\.(\w+)\] (?=has|is|requires)", r"the \1 "),
    (r"^\[chain\] has\b", "the chain has"),
    (r"^struck_by omits the velocity of bead 1, (.*), because strikers hit a chain at rest; .*",
     r"the impact velocity, \1, is not used, because strikers hit a chain at rest; enter the "
     "velocity under Strikers"),
    (r"\badd a light cap: with_cap\('([^']*)'\)", r"add a light cap of \1"),
    (r"\buse Wall\(\) or the material", "choose the material"),
    (r"; see Run\.fronts", ""),
    # Names of tables in chain files.
    (r" of \[chain[.\w]*\]", ""),
    # The page describes the chain, and shows the results of these functions.
    (r" \(chain: .*\)$", ""),
    (r", or a list in brackets$", ", or a blank after each comma of a list"),
    (r"; (?:use (?:simulate|propagate|bca|effective_chain)\b|remove it from the chain$|"
     r"omit (?:it|them): chain)[^;]*$", ""),
)  # fmt: skip


# Advice about a choice, at the end of a warning.
ADVICE: Final = re.compile(r";[^;]* choose the loss.*|; enter the velocity under.*")


def without_advice(warning: str) -> str:
    """A warning of a saved page, on which nothing can be chosen."""
    return ADVICE.sub("", warning)


def on_the_page(message: object) -> str:
    """The message without Python expressions for which the page has a control."""
    # Several errors are in lines of one message.
    lines = str(message).split("\n  ")
    for expression, words in WORDINGS:
        lines = [re.sub(expression, words, each) for each in lines]
    return "\n  ".join(lines)


def warnings_on_the_page(warned: Iterable[Warning]) -> list[str]:
    """Warnings of this package; those of NumPy about overflows do not help on the page."""
    return [on_the_page(each) for each in warned if not isinstance(each, RuntimeWarning)]


def sentences(notes: Iterable[object]) -> str:
    """Different notes, which have no full stop, one after another."""
    return "; ".join(dict.fromkeys(on_the_page(each).rstrip(".") for each in notes if str(each)))


def title(name: str) -> str:
    """Name of a theory on the page, as in `results.js`."""
    return name_of(name)


def chain_in_words(chain: Chain) -> str:
    """Description of a chain with its strikers and impact velocity."""
    count = chain.strikers
    if not count:
        return chain.description + impact_in_words(chain.velocities, chain.units)
    radii = chain.radii[:count]
    if not chain.scaled and not chain.strikers_are_spheres:
        # Such as a flat striker, which is represented by a sphere of its mass.
        size = engineering(1e3 * float(chain.masses[:count].sum()), "g")
    elif chain.scaled:
        size = f"radius {_ends(radii)}"
        if not chain.strikers_are_spheres:
            size += f", mass {_ends(chain.masses[:count])}"
    else:
        size = sizes_in_words(radii)
    apart = float(chain.gaps[:count].max())
    if apart > 0.0:
        size += f", gap {f'{apart:.4g}' if chain.scaled else length_in_words(apart)}"
    name = "striker" if count == 1 else f"{count} strikers"
    speed = impact_in_words(chain.velocities, chain.units)
    # Balls are counted without strikers.
    balls = chain[count:].description.replace(" except bead ", " except ball ")
    return f"{balls}, {name} ({size}){speed}"


def _ends(values: Array) -> str:
    """The first and the last value, or one if they are equal."""
    return " to ".join(dict.fromkeys(f"{each:.4g}" for each in (values[0], values[-1])))

"""Labels and titles of axes in which several spectra have curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from ..chain.chain import Chain
from .curve_notes import CurveNotes
from .differences import words_of_chains
from .labels import distinguish, numbered
from .style import literal, set_title
from .titles import chain_words, load_in_title


@dataclass
class _Curve:
    """The chain of a curve, its own words, and the label that was given to it."""

    chain: Chain
    words: tuple[str, ...]
    label: str = ""


_curves: Final = CurveNotes[_Curve]()


def note_spectrum(line: Line2D, chain: Chain, *words: str) -> None:
    """Remember the chain of a curve, and words such as its mode, for others in the same axes."""
    _curves.add(line, _Curve(chain, words, str(line.get_label())))


def words_of_spectra(axes: Axes) -> list[tuple[str, ...]]:
    """The words of each curve of a spectrum in axes."""
    return [curve.words for curve in _curves.of(axes).values()]


def label_spectra(axes: Axes, *about: str, every_word: bool = False) -> None:
    """Label several curves by the properties in which they or their chains differ.

    With ``every_word``, labels have all words of a curve, also that of a single one.  The title has
    the common properties and words ``about`` the curves, which with ``every_word`` belong to a
    single chain.  Labels of users remain.
    """
    noted = _curves.of(axes)
    lines, curves = list(noted), list(noted.values())
    chains = list({id(curve.chain): curve.chain for curve in curves}.values())
    differing, common = _described(chains)
    of_chain = dict(zip(map(id, chains), differing, strict=True))
    shared = set() if every_word else set.intersection(*(set(curve.words) for curve in curves))
    names = []
    for curve in curves:
        own = [word for word in curve.words if word not in shared]
        words = ", ".join(filter(None, (*own, of_chain[id(curve.chain)])))
        names.append(words or curve.words[0])
    if every_word or len(lines) > 1:
        for line, curve, name in zip(lines, curves, numbered(names), strict=True):
            if line.get_label() == curve.label:
                line.set_label(name)
                curve.label = name
    if len(chains) == 1 or not every_word:
        common += about
    set_title(axes, ", ".join(common), common=True)


def _described(chains: Sequence[Chain]) -> tuple[list[str], list[str]]:
    """Words of each chain that others do not have, and common ones with the static force."""
    first = chains[0]
    alone = [*filter(None, (chain_words(first), load_in_title(first)))]
    every = words_of_chains(chains) if len(chains) > 1 else [alone]
    names, _ = distinguish([["", *words] for words in every])
    common = [part for part in every[0] if all(part in other for other in every)]
    return [literal(name) for name in names], [literal(part) for part in common]

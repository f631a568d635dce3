"""Convert formulas in lines of text to MathML, which browsers draw without scripts.

A formula is between dollar signs: ``$c_be = 1.32 q^(-0.0252)$``.  ``_`` and ``^`` are followed by
one name, number or parenthesised group; the parentheses of an exponent are not shown.
"""

from __future__ import annotations

import re
from typing import Final

from markupsafe import Markup, escape

FORMULA: Final = re.compile(r"\$([^$]+)\$")
# A name with subscripts or exponents, such as E_90, which is a formula without dollar signs, too.
NAME: Final = re.compile(r"\b([A-Za-zα-ω]′?(?:[_^](?:\([^()]*\)|\w+))+)")
TOKENS: Final = re.compile(r"\d+(?:\.\d+)?|ln|[A-Za-zα-ωΑ-Ω]′?|[_^()\[\]]|\S")
SCRIPT: Final = re.compile(r"([_^])(\d+(?:\.\d+)?|[A-Za-z]+|\()")
CLOSING: Final = {"(": ")", "[": "]"}
OPERATORS: Final = {"-": "−"}


def typeset(text: str) -> Markup:
    """Convert the formulas of a line of text to MathML, and escape the rest."""
    parts: list[Markup] = []
    for number, part in enumerate(FORMULA.split(text)):
        if number % 2:
            parts.append(mathml(part))
        else:
            pieces = enumerate(NAME.split(part))
            parts += [mathml(piece) if odd % 2 else escape(piece) for odd, piece in pieces]
    return Markup("").join(parts)


def plain(text: str) -> str:
    """Remove the marks of formulas, for output without MathML."""
    return FORMULA.sub(r"\1", text)


def mathml(formula: str) -> Markup:
    """Convert one formula to a ``math`` element."""
    content, rest = _row(formula, 0, "")
    if rest != len(formula):
        raise ValueError(f"the formula {formula!r} has an unmatched parenthesis")
    return Markup("<math>{}</math>").format(content)


def _row(text: str, at: int, until: str) -> tuple[Markup, int]:
    """Elements up to a closing parenthesis or the end of the text."""
    items: list[Markup] = []
    while at < len(text) and text[at] != until:
        if text[at].isspace():
            at += 1
            continue
        item, at = _atom(text, at)
        subscript, at = _script(text, at, "_")
        superscript, at = _script(text, at, "^")
        if not subscript:
            subscript, at = _script(text, at, "_")
        items.append(_scripted(item, subscript, superscript))
    return Markup("<mrow>{}</mrow>").format(Markup("").join(items)), at


def _atom(text: str, at: int) -> tuple[Markup, int]:
    """A number, a name, an operator or a group in parentheses."""
    match = TOKENS.match(text, at)
    assert match is not None
    token, end = match[0], match.end()
    if token in CLOSING:
        content, end = _row(text, end, CLOSING[token])
        if end == len(text):
            raise ValueError(f"the formula {text!r} has an unmatched parenthesis")
        pair = Markup("<mrow><mo>{}</mo>{}<mo>{}</mo></mrow>")
        return pair.format(token, content, CLOSING[token]), end + 1
    if token in CLOSING.values():
        raise ValueError(f"the formula {text!r} has an unmatched parenthesis")
    if token[0].isdigit():
        return Markup("<mn>{}</mn>").format(token), end
    if token[0].isalpha():
        return Markup("<mi>{}</mi>").format(token), end
    return Markup("<mo>{}</mo>").format(OPERATORS.get(token, token)), end


def _script(text: str, at: int, mark: str) -> tuple[Markup | None, int]:
    """The subscript or superscript at a place, if there is one."""
    match = SCRIPT.match(text, at)
    if match is None or match[1] != mark:
        return None, at
    if match[2] == "(":
        content, end = _row(text, match.end(), ")")
        if end == len(text):
            raise ValueError(f"the formula {text!r} has an unmatched parenthesis")
        return content, end + 1
    kind = "mn" if match[2][0].isdigit() else "mi"
    return Markup("<{0}>{1}</{0}>").format(kind, match[2]), match.end()


def _scripted(item: Markup, subscript: Markup | None, superscript: Markup | None) -> Markup:
    """An element with its subscript and superscript."""
    if subscript is not None and superscript is not None:
        return Markup("<msubsup>{}{}{}</msubsup>").format(item, subscript, superscript)
    if subscript is not None:
        return Markup("<msub>{}{}</msub>").format(item, subscript)
    if superscript is not None:
        return Markup("<msup>{}{}</msup>").format(item, superscript)
    return item

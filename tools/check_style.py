"""Search prose for expressions that CONTRIBUTING.md asks to avoid.

    python tools/check_style.py [--suggestions] [PATH ...] [--skip PATH ...]

It reads Markdown files, Jinja templates, docstrings, comments and string literals, without code,
formulas and quotations.  Without PATH, all tracked files are searched.  The exit code is 1 if an
expression of level "error" is found; suggestions also match legitimate text and are printed only
on request.
"""

import argparse
import ast
import bisect
import io
import itertools
import re
import subprocess
import sys
import tokenize
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final, NamedTuple

ROOT: Final = Path(__file__).resolve().parents[1]
# Files that quote the expressions or texts of others.
QUOTING: Final = ("tools/check_style.py", "tests/test_style_checker.py", "CHANGELOG.md")
# Placeholder for a value within a message.
CODE: Final = "`x`"

ERRORS: Final = {
    "archaic word": r"\b(lest|whence|anew|mended|whosoever|thereof|therein)\b",
    "compare with": r"\b(hold|holds|held|holding)\b[^.]{0,60}\bagainst\b",
    "resume, continue": r"\b(go|goes|going|went|gone) on (from|with|where|to)\b|\bgoes on\b",
    "one row per bead": (
        r"\b(row|line|file|symbol|factor|one|points|column) an? (bead|chain|contact|batch|second|"
        r"processor|step|moment|rate|command|family|taper|parameter)\b"
    ),
    "is not a, does not": (
        r"(?<!there )\b(is|are|was|were|become|becomes) no (?!longer|more|less|better|guarantee)"
        r"[a-z]+\b(?! (in|of|for|on) (the|this))"
    ),
    "name the thing": r"\bwhat is no\b|\bof what\b|\bthat (is|are) no\b",
    "noun instead of a clause with what": (
        r"(?:^|[.:;] )What (?!you|is new)[a-z]+ [^?]{3,90}[.:;]"
    ),
    "software is not a person": (
        r"(?<!\b(you|who) )\b(knows?|wants?|hears?|heard|feels?|felt|sees to|speaks?|tells?|told|"
        r"refuse[sd]?|refusing|judge[sd]?|judging)\b"
    ),
    "private metaphor": r"\b(floors?|house|doors?|bench|ledger|complaints?|border(?!:))\b",
    "printed values, all digits": r"\b(the|very) (print|digits)\b(?! of)",
    "y axis, x axis, %": r"\b(ordinate|abscissa|per cent)\b",
}
SUGGESTIONS: Final = {
    "name the person or thing": r"\b(whatever|whoever|nobody|somebody|anybody|people)\b",
    "in total": r"\bin all\b(?! (cases|chains|beads|contacts|directions|but|of|the|its))",
    "own, separate": r"\b(of (its|your|their|one's) own)\b",
    "is in, is next to, denotes": (
        r"\b(stands?|stood) (in|beside|for|there|below|above|behind|next)\b"
    ),
    "idiom": (
        r"\b(comes? to nothing|counts? as none|as good as none|done away|will do|for good|"
        r"under way|at once|let go|come loose)\b"
    ),
    "a more precise verb": (
        r"\b(is|are|was|were) (left|given|put|thrown|taken|handed) (out|up|in|back|on|away)\b"
    ),
    "this many, at this interval": r"\b(so (many|often|much) (?!that|as))[a-z]+",
    "next to, in addition to": r"\bbeside\b",
    "requested": r"\b(asked for|as asked|ask(s|ed)? of)\b",
    "carries a force": r"\bbears?\b|\bborne\b",
    "transfers, returns": r"\bhand(s|ed)? (on|back|over)\b|\b(gives|comes) back\b",
    "only": r"\balone\b",
    "except for, instead of": r"\bbut for\b|\bin place of\b",
    "has an error of": r"\b(off|wrong) by\b",
    "heterogeneous": r"\buneven\w*\b",
    "time, instant": r"\bmoments?\b",
    "does not give: is rigid": r"\b(does|do) not give\b",
    "plot, figure": r"\b(pictures?|drawings?)\b",
    "the simulation": r"\bthe integration\b",
    "accurate to, bit for bit": r"\bright to\b|\bto the last (bit|digit)\b|\bto the letter\b",
    "omit": r"\b(leave|leaves|left|leaving) out\b|\bleft away\b",
    "the problem with a clause": r"\b(says|say|said) (what|how|where|which|so)\b",
    "a long sentence": r"[^.!?:\n|`$]{240,}[.!?]",
    "a pronoun without antecedent": (
        r"(?<=\. )(It|They|These|Those|Both|This|Such) (is|are|does|do|has|have|goes|makes?)\b"
    ),
}


# Lines of prose that belong together, each with its number.
Paragraph = list[tuple[int, str]]


class Finding(NamedTuple):
    """An expression found in a file."""

    line: int
    level: str
    advice: str
    text: str


def paragraphs(lines: list[tuple[int, str]]) -> Iterator[Paragraph]:
    """Split numbered lines at empty ones, at list items and at table rows."""
    gathered: list[tuple[int, str]] = []
    for number, line in lines:
        text = line.strip()
        if gathered and (not text or re.match(r"([-*+#|]|\d+\.) ?|<!--", text)):
            yield gathered
            gathered = []
        if text:
            gathered.append((number, text))
    if gathered:
        yield gathered


def markdown_prose(text: str) -> Iterator[Paragraph]:
    """Prose of a Markdown file, without code blocks, block quotations and formulas."""
    lines, fence = [], ""
    for number, line in enumerate(text.splitlines(), start=1):
        opening = re.match(r"\s*(```+|~~~+|\$\$)", line)
        if fence:
            fence = "" if line.strip().endswith(fence) else fence
            line = ""
        elif opening:
            closed = opening[1] == "$$" and line.count("$$") > 1
            fence = "" if closed else opening[1]
            line = ""
        elif line.startswith((">", "    ")):
            line = ""
        lines.append((number, line))
    return paragraphs(lines)


def template_prose(text: str) -> Iterator[Paragraph]:
    """Text of a Jinja template, without its tags and style sheet."""
    blank = r"\{\{.*?\}\}|\{%.*?%\}|<style>.*?</style>|<script>.*?</script>|<[^>]*>"
    kept = re.sub(blank, lambda tag: re.sub(r"[^\n]", " ", tag[0]), text, flags=re.DOTALL)
    return markdown_prose(kept.replace("    ", ""))


def docstring_prose(text: str, first: int) -> Iterator[Paragraph]:
    """Prose of a docstring, without doctests, formulas and literal blocks."""
    lines: list[tuple[int, str]] = []
    block = -1  # indentation of the line that began a block of code or a doctest
    doctest = False
    for number, line in enumerate(text.splitlines(), start=first):
        stripped = line.strip()
        indent = len(line) - len(line.lstrip())
        if stripped.startswith(">>>"):
            doctest = True
        elif not stripped:
            doctest = False
        if stripped and block >= 0 and indent <= block:
            block = -1
        if block < 0 and re.match(r"\.\. (math|code-block|code|rubric)::", stripped):
            block = indent
        kept = "" if doctest or block >= 0 else line
        if block < 0 and not doctest and stripped.endswith("::"):
            block = indent
        lines.append((number, kept))
    return paragraphs(lines)


def comment_prose(text: str) -> Iterator[Paragraph]:
    """Comments of a module; those on successive lines belong together."""
    lines: list[tuple[int, str]] = []
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT and not re.match(r"# (noqa|fmt|type):|#!", token.string):
            number = token.start[0]
            if lines and number != lines[-1][0] + 1:
                yield from paragraphs(lines)
                lines = []
            lines.append((number, token.string.lstrip("#: ")))
    yield from paragraphs(lines)


def literal_prose(node: ast.Constant | ast.JoinedStr) -> Iterator[Paragraph]:
    """Text of a string literal, if it has several words."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    text = "".join(
        part.value if isinstance(part, ast.Constant) and isinstance(part.value, str) else CODE
        for part in parts
    )
    if len(re.findall(r"[A-Za-z]{2,}", text)) > 2 and " " in text:
        yield [(node.lineno, " ".join(text.split()))]


def python_prose(text: str) -> Iterator[Paragraph]:
    """Docstrings, comments and string literals of a module."""
    yield from comment_prose(text)
    inside: set[ast.AST] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.JoinedStr):
            inside.update(node.values)
        body = getattr(node, "body", None)
        if isinstance(body, list):
            for statement in body:
                value = statement.value if isinstance(statement, ast.Expr) else None
                if isinstance(value, ast.Constant) and isinstance(value.value, str):
                    inside.add(value)
                    yield from docstring_prose(value.value, value.lineno)
        if node in inside:
            continue
        if isinstance(node, ast.JoinedStr) or (
            isinstance(node, ast.Constant) and isinstance(node.value, str)
        ):
            yield from literal_prose(node)


READERS: Final[dict[str, Callable[[str], Iterator[Paragraph]]]] = {
    ".md": markdown_prose,
    ".py": python_prose,
    ".pyi": python_prose,
    ".j2": template_prose,
}


def without_code(text: str) -> str:
    """Replace code, formulas, addresses and quotations by as many letters."""
    hidden = r":\w+:`[^`]*`|``[^`]*``|`[^`]*`|\$[^$]+\$|(?<=\])\([^)]*\)|“[^”]*”|\"[^\"]*\""
    return re.sub(hidden, lambda found: "x" * len(found[0]), text)


def search(paragraph: Paragraph, *, suggestions: bool = False) -> Iterator[Finding]:
    """Find the expressions in one paragraph."""
    text = " ".join(line for _, line in paragraph)
    ends = list(itertools.accumulate(len(line) + 1 for _, line in paragraph))
    prose = without_code(text)
    levels = {"error": ERRORS, "suggestion": SUGGESTIONS if suggestions else {}}
    for level, table in levels.items():
        for advice, pattern in table.items():
            for found in re.finditer(pattern, prose, re.IGNORECASE):
                number = paragraph[bisect.bisect_right(ends, found.start())][0]
                yield Finding(number, level, advice, text[found.start() : found.end()])


def tracked_files() -> list[str]:
    """Names of the files that git tracks, relative to the repository."""
    done = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return [name for name in done.stdout.split("\0") if name]


def main(arguments: list[str] | None = None) -> int:
    """Print all findings and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="*", help="files to search (default: all tracked files)")
    parser.add_argument("--skip", nargs="+", default=[], metavar="PATH", help="not searched")
    parser.add_argument("--suggestions", action="store_true", help="print suggestions, too")
    options = parser.parse_args(arguments)
    errors = 0
    for name in options.paths or tracked_files():
        skipped = any(
            name == each or name.startswith(f"{each.rstrip('/')}/") for each in options.skip
        )
        reader = READERS.get(Path(name).suffix)
        if reader is None or skipped or name in QUOTING:
            continue
        for paragraph in reader((ROOT / name).read_text("utf-8")):
            for found in search(paragraph, suggestions=options.suggestions):
                errors += found.level == "error"
                print(f"{name}:{found.line}: {found.level}: {found.advice}: {found.text}")
    return int(errors > 0)


if __name__ == "__main__":
    sys.exit(main())

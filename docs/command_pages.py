"""The reference of the command line: a table of all commands, and examples that can be copied."""

from typing import Any

import click
from sphinx.transforms import SphinxTransform

from hertzchain.cli import GROUPS


class PlainQuotes(SphinxTransform):
    """Keep the straight quotes of commands, which a shell needs; before quotes are replaced."""

    default_priority = 740

    def apply(self, **_: Any) -> None:
        """Set whether the quotes of this page are replaced."""
        self.document.settings.smart_quotes = self.env.docname != "reference/cli"


def command_table() -> str:
    """Return a table in Markdown of all commands, each with a link to its options."""
    lines = ["| for | command | purpose |", "|---|---|---|"]
    for heading, commands in GROUPS.items():
        for i, each in enumerate(commands):
            purpose = each.get_short_help_str(limit=200)
            # sphinx-click writes the headings of commands, to which Markdown cannot refer.
            link = f'<a href="#hertzchain-{each.name}"><code>{each.name}</code></a>'
            lines.append(f"| {'' if i else heading} | {link} | {purpose} |")
    return "\n".join(lines) + "\n"


def examples_as_blocks(_: Any, __: click.Context, lines: list[str]) -> None:
    """Show the examples of a command as blocks of code instead of lines of text."""
    found: list[str] = []
    for line in lines:
        if line.startswith("|  "):
            found.append(f"   {line[4:]}")
        elif line.startswith("| "):
            found += ["", line[2:], "", ".. code-block:: sh", ""]
        else:
            found.append(line)
    lines[:] = found

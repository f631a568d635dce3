"""Messages of the library in the words of the command line."""

from __future__ import annotations

import re
from typing import Final

# Python expressions in messages, and what to write on the command line or in a chain file instead.
WORDINGS: Final = (
    (r"loss=ElasticPlastic\(\)", "the loss law elastic-plastic"),
    (r"loss=ElasticPlastic\(yield_overlap=\.\.\.\)",
     "the loss law elastic-plastic with a yield_overlap"),
    (r"\bloss=None\b", "no loss"),
    (r"\buse largest_so_far\b", "use the largest force so far"),
    (r"\buntil='([^']*)'", r"--until '\1'"),
    (r"(?<!-)\bmax_steps\b", "--max-steps"),
    (r"\bgive load_traces sensors=\{'([^']*)': 'wall'\}", r"add --sensor '\1=wall'"),
    (r"\bgive sensors to load_traces\b", "add --sensor"),
    (r"\bhc\.scoreboard\(\)", "hertzchain scoreboard"),
)  # fmt: skip


def on_command_line(message: str) -> str:
    """The message without Python expressions for which the command line has other words."""
    for expression, words in WORDINGS:
        message = re.sub(expression, words, message)
    return message

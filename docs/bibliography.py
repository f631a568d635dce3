"""The bibliography page, from the references of the package."""

from __future__ import annotations

from hertzchain.citations import SOFTWARE, Reference, topics


def bibliography_page() -> str:
    """The entry of this software and all references by topic, as Markdown with links."""
    parts = [f"## This software\n\n- {SOFTWARE}\n"]
    for topic, references in topics().items():
        parts.append(f"## {topic}\n")
        parts += [_item(each) for each in references]
        parts.append("")
    return "\n".join(parts)


def _item(reference: Reference) -> str:
    authors = ", ".join(reference.authors)
    links = []
    if reference.doi:
        # Parentheses would end the link.
        target = reference.doi.replace("(", "%28").replace(")", "%29")
        links.append(f"[doi:{reference.doi}](https://doi.org/{target})")
    if reference.arxiv:
        links.append(f"[arXiv:{reference.arxiv}](https://arxiv.org/abs/{reference.arxiv})")
    law = f"`{reference.law}`: " if reference.law else ""
    source = f"*{reference.title}*, {reference.source}".replace(", (", " (")
    return f"- {law}{authors}, {', '.join([source, *links])}."

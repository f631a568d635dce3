"""Pages in the sidebar, found once: Sphinx would resolve all tables of contents for each page."""

from __future__ import annotations

import functools
from typing import Any, NamedTuple

from sphinx import addnodes


class Entry(NamedTuple):
    """A page in the sidebar: its name, its title there, and the page and all pages below it."""

    page: str
    title: str
    pages: frozenset[str]


def add_navigation(app: Any, _: str, __: str, context: dict[str, Any], ___: Any) -> None:
    """Give templates the captions of the sidebar, each with its entries."""
    context["navigation"] = _navigation(app.env)


@functools.cache
def _navigation(env: Any) -> list[tuple[str, list[Entry]]]:
    root = env.get_doctree(env.config.root_doc)
    return [
        (each["caption"], [_entry(env, title, page) for title, page in each["entries"]])
        for each in root.findall(addnodes.toctree)
    ]


def _entry(env: Any, title: str | None, page: str) -> Entry:
    return Entry(page, title or env.titles[page].astext(), frozenset(_below(env, page)))


def _below(env: Any, page: str) -> set[str]:
    return {page}.union(*(_below(env, each) for each in env.toctree_includes.get(page, ())))

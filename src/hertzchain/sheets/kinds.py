"""Kinds of rows: columns."""

from __future__ import annotations

from ..chain.chain import Chain


def is_column(chain: Chain) -> bool:
    """Whether the row is vertical, and its first ball is at the top."""
    return chain.gravity > 0.0

"""Kinds of rows: columns, and rows in front of a load cell."""

from __future__ import annotations

from ..chain.chain import Chain


def is_load_cell(chain: Chain) -> bool:
    """Whether the wall behind the row is a linear spring, such as a load cell."""
    return chain.right_wall is not None and float(chain.contact_exponents[-1]) == 1.0


def is_column(chain: Chain) -> bool:
    """Whether the row is vertical, and its first ball is at the top."""
    return chain.gravity > 0.0

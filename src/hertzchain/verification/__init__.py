"""Exact and published values of the field, and ours beside them."""

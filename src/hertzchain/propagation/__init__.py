"""Simulate the leading pulse only, in a window of beads that moves along the chain."""

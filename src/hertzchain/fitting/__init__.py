"""Fit chains to measured traces: materials, losses and gaps, with errors."""

"""Integration of the equations of motion of all beads, and evaluation of runs."""

"""Largest relative error of the columns of a pulse."""

COLUMNS = ("velocity", "peak_time", "arrival", "peak_overlap")


def largest_error(pulse, exact):
    """Largest relative error of any column at any bead, the first included."""
    return max(pulse.compare(exact).worst(name, first_bead=1) for name in COLUMNS)

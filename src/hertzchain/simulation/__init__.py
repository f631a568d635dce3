"""Every bead at every time: the equations of motion, and what a run of them tells."""

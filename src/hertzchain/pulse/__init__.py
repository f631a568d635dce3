"""What comes out of every simulation and every theory, and how two of them compare."""

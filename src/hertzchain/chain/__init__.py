"""Description of a chain: beads, materials, losses, walls, drives, strikers; builders, checks."""

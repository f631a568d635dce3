"""What is hit: the beads, how they touch, what holds them and what strikes them."""

"""The leading pulse alone, followed along the chain by windows of a few beads."""

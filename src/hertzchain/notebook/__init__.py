"""HTML representations of chains and results for notebooks: a small figure and key numbers."""

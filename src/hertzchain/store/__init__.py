"""Files: the only package that knows formats."""

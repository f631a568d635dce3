"""Checks of arguments: keywords, numbers, objects and memory; conversion to JSON types."""

"""Argument checks: numbers and arrays (`numbers`), all other objects (`objects`)."""

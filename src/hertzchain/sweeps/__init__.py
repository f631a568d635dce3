"""Sweeps of parameters, by one or several methods, into one labelled dataset."""

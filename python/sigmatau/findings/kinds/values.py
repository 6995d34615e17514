"""Kinds of findings about sample values: held, repeated, lost, saturated, interpolated, coarse, in a wrong unit."""

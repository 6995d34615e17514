"""Kinds of findings about curves and fits."""

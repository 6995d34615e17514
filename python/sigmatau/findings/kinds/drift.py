"""Kinds of findings about slow changes: warm-up, temperature, noise that changes, selection of a window."""

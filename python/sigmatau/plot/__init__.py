"""Figures, drawn from plain arrays. matplotlib is imported in the call."""

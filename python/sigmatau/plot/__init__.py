"""Figures. Everything here draws from plain arrays, and matplotlib is imported in the call."""

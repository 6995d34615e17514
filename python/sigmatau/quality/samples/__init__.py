"""Checks of samples: one module per kind of fault."""

"""Checks of slow changes: warm-up, temperature, noise that does not stay the same."""

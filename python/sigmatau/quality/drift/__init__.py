"""Checks of slow changes: warm-up, temperature, noise that changes."""

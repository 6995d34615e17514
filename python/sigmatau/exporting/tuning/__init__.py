"""Test of a filter by its innovations: finds the wrong noise and its factor."""

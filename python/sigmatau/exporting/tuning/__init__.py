"""Test of a filter by its innovations: which of its noises is wrong, and by which factor."""

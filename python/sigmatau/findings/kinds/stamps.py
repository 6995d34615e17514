"""Kinds of findings about time stamps: rate, gaps, jitter, clock."""

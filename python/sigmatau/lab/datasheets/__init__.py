"""Datasheet specifications, and comparison of a sensor with them."""

"""Datasheet specifications, and whether a sensor meets them."""

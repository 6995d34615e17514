"""Runs, days, units and axes beside each other: repeatability."""

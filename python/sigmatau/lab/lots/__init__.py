"""Comparison of runs, days, units and axes: repeatability."""

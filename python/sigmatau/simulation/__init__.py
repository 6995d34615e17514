"""Simulated records, in memory or in a file of any length."""

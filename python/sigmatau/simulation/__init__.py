"""Simulated records: in memory, or straight into a file of any length."""

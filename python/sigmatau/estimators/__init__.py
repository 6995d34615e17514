"""Estimators: the Allan variance and other deviations, averaging times, gaps, records in pieces, stability over time."""

"""Findings that need a curve, a spectrum or a fit, and what each does to which coefficient."""

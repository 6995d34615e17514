"""Kinds of findings about spectra: lines, low-pass filters, resampling, common noise."""

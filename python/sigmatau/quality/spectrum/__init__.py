"""Checks of spectra: lines, low-pass filters, resampling, noise common to axes."""

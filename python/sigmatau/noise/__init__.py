"""The five noise terms, and the uncertainty of deviations."""

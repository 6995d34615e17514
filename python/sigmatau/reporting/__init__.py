"""Reports: a page with curves, coefficients, findings about the record, and the processing steps.

`content` collects it from an analysis, as text (`texts`) and as numbers to draw (`charts`); `html` and `pdf` write it.
"""

"""Reports: one page with the curves, the coefficients, what is wrong with the record, and what was done.

`content` collects it from an analysis, as text (`texts`) and as numbers to draw (`charts`); `html` and `pdf` write it.
"""

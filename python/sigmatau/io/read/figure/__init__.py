"""Reading of curves out of figures: vector paths of SVG and PDF files, and clicked points.

`svg` and `pdf` return the paths and texts of a page in one system of coordinates, with y downwards. `candidates` selects the
paths that can be curves, `ticks` calibrates the axes by labels and `axis` by stated points, `clicks` reads clicked points,
and `select` puts them together.
"""

"""Power spectral densities of a record, and lines in them."""

"""The only modules that import the compiled extension: they convert arguments and word errors."""

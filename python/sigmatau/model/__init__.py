"""Noise models: from a file, a fit or by hand, with their expected Allan variance, density and covariance."""

"""Noise models as linear systems: Kalman matrices, ARMA, and their verification against a record."""

"""Kinds of findings about disturbances: motion, shocks, steps of the level, spikes, start transients."""

"""Files for filters and simulators, from a noise model."""

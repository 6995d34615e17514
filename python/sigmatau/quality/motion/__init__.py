"""Motion of a sensor that should rest: shocks, steps of the mean, and whether it is at rest at all."""

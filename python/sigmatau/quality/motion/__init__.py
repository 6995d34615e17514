"""Motion of a sensor that should be at rest: shocks, steps of the mean, and whether the sensor is at rest."""

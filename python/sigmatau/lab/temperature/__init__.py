"""Temperature: noise and bias over a ramp, a soak or several runs; bias polynomial, hysteresis, firmware parameters."""

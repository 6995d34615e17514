"""Arrays of sensors: covariance of several sensors of one axis, weights of a virtual sensor, N-cornered hat."""

"""Monte Carlo studies that support the constants and claims of the package; ``make study`` runs them all."""

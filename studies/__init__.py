"""Monte Carlo studies behind the constants and claims of the package; ``make study`` runs them all."""

"""Results database: units, runs, coefficients, findings and curves, on SQLite or PostgreSQL."""

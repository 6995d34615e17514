"""Error growth of unaided inertial navigation at rest."""

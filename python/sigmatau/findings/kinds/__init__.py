"""The kinds of findings: one frozen dataclass per kind, in SI units, with its code; one module per subject."""

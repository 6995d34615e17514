"""docs/paper/sampling.md in less time."""

SUBSTITUTED = {"duration=600": "duration=20", "--overlay rates.png": "--overlay rates.png --method read-off"}

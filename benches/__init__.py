"""Speed: against other packages, against what the machine can do, and in instructions."""

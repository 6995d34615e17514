"""Speed: compared with other packages and with the limits of the machine, and in instructions."""

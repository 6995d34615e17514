"""Conversion of options from typed text to values and back, for the command line, configuration files and the workbench."""

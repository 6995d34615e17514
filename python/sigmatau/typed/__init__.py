"""Options as they are typed: texts to values and back, for the command line, configuration files and the workbench."""

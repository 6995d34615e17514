"""The site of the documentation: collection of its pages, build and checks."""

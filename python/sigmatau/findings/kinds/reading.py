"""Kinds of findings about files: damage, leftovers, columns, units."""

"""Kinds of findings about exported files and files read back."""

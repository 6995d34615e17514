"""The five noise terms, and how sure a deviation is."""

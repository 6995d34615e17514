"""The part of a record that is analysed."""

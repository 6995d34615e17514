"""The only importers of the compiled extension: casts and checks on the way in, the words of errors on the way out."""

"""The formats that are read, one module each, and what several of them share."""

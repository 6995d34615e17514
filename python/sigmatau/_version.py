"""The version of the program and of the JSON form, in a module without further imports."""

__version__ = "0.1.0"
SCHEMA = 2
"""Version of the JSON form of a result; a JSON Schema of it is in sigmatau/schema."""

"""The version, and that of the JSON form, where nothing else has to be imported for them."""

__version__ = "0.1.0"
SCHEMA = 2
"""Version of the JSON form of a result; a JSON Schema of it is in sigmatau/schema."""

"""What is wrong with a record, and what is left out of it."""

"""The site of the documentation: what puts its pages together, builds it and checks it."""

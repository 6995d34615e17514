"""Pages of a lot: HTML, PDF, tables, JUnit XML."""

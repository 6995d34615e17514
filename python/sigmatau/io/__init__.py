"""Files: logs into records, records into tables."""

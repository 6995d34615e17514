"""Many logs, or one very long one, on several processes or hosts; the results go into a store."""

"""Analysis of many logs, or of a very long one, on several processes or hosts, with the results in a store."""

"""Which noise of a filter is wrong, and by which factor, from its innovations."""

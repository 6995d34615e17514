"""From stamps to a uniform grid: which rows count, what the interval is, what the stamps say about their clock."""

"""Time stamps to a uniform grid: order of rows, sample interval, missing samples, quality of the clock."""

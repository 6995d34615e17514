"""The laboratory: datasheets, lots of units, runs of a unit, the results store and many logs on several processes."""

"""Records: streams of samples on uniform grids, missing samples, thermometers, memory."""

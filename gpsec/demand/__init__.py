"""Random traffic for a net that has none, made with SUMO's own tools."""

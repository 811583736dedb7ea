"""The HD map: lane geometry as arrays, and matching."""

"""OpenStreetMap: what an extract says, and the net that netconvert makes of it."""

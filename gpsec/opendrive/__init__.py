"""OpenDRIVE: its lane geometry, the net that netconvert makes of it, and the check of one against the other."""

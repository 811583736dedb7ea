"""The installed SUMO: where it is, and how its programs are run."""

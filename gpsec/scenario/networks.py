"""The networks of gpsec that detectors are trained and calibrated on."""

# None of these is among the networks that results are reported on.
TRAINING_NETWORKS = ("mountain", "suburb", "beltway")

"""What gpsec costs, measured against SUMO itself: ``python -m benchmarks``."""

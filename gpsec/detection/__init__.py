"""Attack detectors on the lateral residual."""

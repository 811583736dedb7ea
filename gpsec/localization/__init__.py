"""State estimation with and without GNSS."""

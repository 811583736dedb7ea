"""How vehicles that steer by their estimate move across the road, and what they do on an alarm."""

"""What each attack achieved: events, metrics, tables."""

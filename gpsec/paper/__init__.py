"""The published tables, re-created on our own networks and set beside the published figures."""

"""GPS-spoofing attacks, and the plans that say who is attacked when."""

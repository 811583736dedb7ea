"""Films the traffic of a scenario: pictures of any vehicle's view, and by how much lanes in them are off."""

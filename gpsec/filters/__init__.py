"""Filters that stages share: what they know of the sensors, and how odometer, gyro and fixes move them."""

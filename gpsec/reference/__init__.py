"""The same method for one vehicle at a time, with filterpy, shapely and scikit-learn."""

"""Pictures of the lane, rendered and real, and the method's image processing; the only part that imports OpenCV."""

"""The lane in pictures: rendered and real views, the method's image processing, and the errors that it makes."""

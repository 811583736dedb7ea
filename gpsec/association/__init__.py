"""Which lane of its map a vehicle believes to be on, from what its own sensors give it: never from the simulator."""

"""Road networks: authored as OpenDRIVE by :mod:`sumo_nets.build`, imported by netconvert."""

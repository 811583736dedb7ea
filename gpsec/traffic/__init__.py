"""The traffic: libsumo, recordings, and the kinematic body of each vehicle."""

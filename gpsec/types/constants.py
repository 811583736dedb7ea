"""Names that several stages write or read: of files, of the undefended vehicle, of SUMO's parameters."""

MANIFEST = "manifest.json"
"""Of a run: its scenario, versions, cost and fingerprint. It is written last."""
REPORT = "report.html"
"""Of a run, for people."""
UNDEFENDED = "never+none"
"""The defence of the vehicle that trusts GNSS: its detector never raises an alarm, and nothing responds."""
PREFIX = "gpsec."
"""Of gpsec's generic parameters in SUMO's files, such as ``gpsec.attack``."""
ASSOCIATIONS = ("tracked", "nearest", "oracle")
"""How a vehicle knows which lane it is on; the first is the default, the last a bound."""
MODELLED = ("tracked", "nearest")
"""The associations that detectors are trained with. What is told the lane shares the models of the first."""

"""On which side of the road traffic keeps, which OpenStreetMap hardly ever says."""

import shapely

from gpsec.openstreetmap.extract import Extract
from gpsec.openstreetmap.outlines import LEFT_HAND

# One direction of roundabouts must be this many times as frequent as the other.
_CLEAR = 2


def extract_keeps_left(extract: Extract) -> tuple[bool, str]:
    """Return whether traffic keeps left, and how one knows: from its roundabouts, which are drawn as they are driven.

    Without roundabouts, or where they disagree, the place counts.
    """
    found = extract.clockwise, extract.counterclockwise
    if max(found) > _CLEAR * min(found):
        left = found[0] > found[1]
        way = "clockwise" if left else "counter-clockwise"
        return left, f"as {max(found)} of {sum(found)} roundabouts are driven {way}"
    lat, lon = extract.centre_deg
    place = shapely.Point(lon, lat)
    where = next((name for name, outline in LEFT_HAND.items() if shapely.Polygon(outline).contains(place)), None)
    return (True, f"as in {where}") if where else (False, "as in most countries")

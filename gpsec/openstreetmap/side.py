"""Finds the side on which traffic keeps, from roundabouts or from the place; OpenStreetMap seldom states it.

The outlines, (longitude, latitude) in degrees, are drawn by hand. They keep to the coasts and, on land, to within some
50 km of the borders; on islands they are boxes. Some small islands are missing. Which countries: ScienceAlert, "A
Surprisingly Few Number of Countries Drive on The Left Side of The Road".
"""

import shapely

from gpsec.openstreetmap.extract import Extract

CountryOutline = tuple[tuple[float, float], ...]


def _box(west: float, south: float, east: float, north: float) -> CountryOutline:
    return (west, south), (east, south), (east, north), (west, north)


LEFT_HAND: dict[str, CountryOutline] = {
    "Great Britain and Ireland": (
        (-6.5, 49.7), (-1.0, 50.3), (1.1, 50.75), (1.45, 51.05), (2.2, 52.4), (2.0, 53.5), (0.0, 55.5), (-0.3, 61.2),
        (-9.0, 61.2), (-11.0, 55.0), (-11.0, 51.0),
    ),
    "the Channel Islands": _box(-2.75, 49.1, -1.98, 49.76),
    "Malta": _box(14.1, 35.7, 14.7, 36.15),
    "Cyprus": _box(32.2, 34.4, 34.7, 35.75),
    "Japan": (
        (122.6, 23.8), (154.5, 23.8), (154.5, 30.0), (145.9, 43.4), (145.3, 43.7), (145.4, 44.4), (142.0, 45.65),
        (141.0, 45.7), (138.0, 40.0), (132.5, 36.8), (129.5, 34.95), (128.9, 34.3), (128.0, 32.8), (128.0, 30.0),
        (122.6, 25.2),
    ),
    "southern Asia": (
        (61.6, 25.0), (63.2, 27.2), (60.9, 29.9), (66.3, 29.9), (66.6, 31.9), (69.3, 31.9), (70.0, 33.3), (71.1, 34.2),
        (71.6, 36.3), (74.5, 37.0), (77.8, 35.5), (79.0, 32.6), (81.2, 30.0), (84.0, 28.8), (86.0, 28.0), (88.6, 28.0),
        (91.7, 27.8), (95.0, 29.2), (97.3, 28.2), (95.2, 26.7), (94.4, 25.0), (93.3, 24.0), (92.7, 22.2), (92.3, 20.6),
        (90.0, 19.0), (83.0, 5.0), (73.5, -1.0), (72.0, -1.0), (71.5, 8.0), (66.0, 22.0),
    ),
    "the Andaman and Nicobar Islands": _box(92.0, 6.4, 94.2, 13.9),
    "Thailand and the Malay Peninsula": (
        (98.0, 7.0), (98.4, 10.2), (99.4, 11.8), (99.1, 13.6), (98.5, 15.2), (97.9, 17.5), (97.5, 18.5), (98.1, 19.7),
        (100.0, 20.3), (100.5, 19.6), (101.1, 19.4), (101.1, 17.8), (102.1, 18.1), (102.7, 17.85), (103.4, 18.3),
        (104.6, 17.4), (104.7, 16.4), (105.4, 15.3), (105.2, 14.4), (103.0, 14.3), (102.5, 13.6), (102.8, 11.8),
        (102.0, 9.0), (105.5, 4.0), (105.5, 0.0), (98.0, 0.0),
    ),
    "Indonesia and Borneo": _box(94.5, -11.5, 119.2, 6.4),
    "eastern Indonesia": _box(119.2, -11.5, 141.5, 4.4),
    "Papua New Guinea": _box(140.5, -12.0, 156.2, 0.0),
    "the Solomon Islands": _box(155.3, -12.6, 168.0, -5.0),
    "Australia": _box(112.0, -44.5, 154.5, -9.0),
    "New Zealand": _box(165.8, -48.0, 179.5, -34.0),
    "Fiji": _box(176.5, -20.0, 180.0, -15.5),
    "Tonga": _box(-176.5, -22.5, -173.5, -15.3),
    "Samoa": _box(-173.0, -14.15, -171.3, -13.3),
    "Hong Kong": _box(113.82, 22.13, 114.5, 22.5),
    "Macau": _box(113.52, 22.1, 113.6, 22.216),
    "southern and eastern Africa": (
        (11.5, -17.3), (14.0, -17.5), (18.4, -17.5), (21.0, -18.0), (23.3, -17.7), (22.1, -16.3), (22.1, -13.1),
        (24.0, -13.0), (24.1, -11.1), (25.4, -11.8), (27.1, -12.1), (28.4, -12.6), (29.7, -13.5), (29.7, -12.3),
        (28.6, -11.9), (28.5, -9.3), (29.0, -8.5), (30.7, -8.3), (29.5, -6.0), (29.7, -4.5), (30.7, -2.9), (30.8, -2.2),
        (30.4, -1.1), (29.7, -1.3), (29.8, 0.6), (31.2, 2.2), (30.9, 3.4), (34.0, 4.2), (35.9, 4.6), (41.7, 3.9),
        (40.9, 2.7), (40.9, -0.8), (41.5, -1.8), (41.0, -11.0), (41.2, -16.0), (36.0, -26.0), (33.0, -31.0),
        (20.0, -36.0), (17.0, -36.0), (16.0, -30.0), (13.0, -26.0),
    ),
    "Mauritius": _box(57.2, -20.6, 63.6, -19.6),
    "the Seychelles": _box(46.0, -10.5, 56.5, -3.5),
    "Jamaica": _box(-78.5, 17.6, -76.1, 18.6),
    "the Bahamas": ((-79.5, 27.4), (-79.4, 23.6), (-77.0, 22.4), (-75.3, 21.6), (-73.8, 20.8), (-72.6, 20.8),
                    (-72.5, 24.5), (-76.0, 27.4)),
    "the Turks and Caicos Islands": _box(-72.6, 21.1, -71.0, 22.0),
    "the Cayman Islands": _box(-81.5, 19.2, -79.6, 19.8),
    "Trinidad and Tobago": ((-61.95, 10.0), (-60.4, 10.0), (-60.4, 11.4), (-61.5, 11.0), (-61.8, 10.65)),
    "Barbados": _box(-59.7, 13.0, -59.4, 13.4),
    "Antigua and Barbuda": _box(-62.0, 16.9, -61.6, 17.75),
    "Dominica": _box(-61.5, 15.18, -61.2, 15.67),
    "Saint Lucia": _box(-61.1, 13.7, -60.85, 14.13),
    "Saint Vincent and Grenada": _box(-61.85, 11.95, -61.05, 13.42),
    "Saint Kitts and Nevis": _box(-62.9, 17.05, -62.5, 17.45),
    "Anguilla": _box(-63.2, 18.13, -62.9, 18.3),
    "Montserrat": _box(-62.25, 16.65, -62.1, 16.85),
    "the Virgin Islands": _box(-65.1, 17.6, -64.2, 18.8),
    "Guyana and Suriname": ((-61.3, 5.9), (-59.9, 8.5), (-57.0, 6.4), (-54.1, 6.0), (-54.5, 4.0), (-54.5, 2.4),
                            (-56.0, 1.9), (-59.5, 1.3), (-60.0, 4.5)),
    "Bermuda": _box(-65.0, 32.2, -64.6, 32.45),
    "the Falkland Islands": _box(-61.6, -52.6, -57.6, -51.0),
}  # fmt: skip


# One direction of roundabouts must be this many times as frequent as the other.
_CLEAR = 2


def extract_keeps_left(extract: Extract) -> tuple[bool, str]:
    """Return whether traffic keeps left, and the reason: its roundabouts, which are drawn as they are driven.

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

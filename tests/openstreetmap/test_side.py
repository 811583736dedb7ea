"""Which side traffic keeps to comes from roundabouts, else from the place."""

from pathlib import Path

import pytest
import shapely

from gpsec.openstreetmap.extract import Extract, read_extract
from gpsec.openstreetmap.side import LEFT_HAND, extract_keeps_left

from .maps import Way, document, ring, write

LEFT = {
    "London": (51.51, -0.13), "Dover": (51.13, 1.31), "Dublin": (53.35, -6.26), "Lerwick": (60.15, -1.14),
    "Tokyo": (35.68, 139.77), "Naha": (26.21, 127.68), "Wakkanai": (45.41, 141.67), "Delhi": (28.61, 77.21),
    "Karachi": (24.86, 67.0), "Dhaka": (23.81, 90.41), "Kathmandu": (27.72, 85.32), "Colombo": (6.93, 79.86),
    "Male": (4.18, 73.51), "Bangkok": (13.76, 100.5), "Chiang Mai": (18.79, 98.99), "Singapore": (1.35, 103.82),
    "Jakarta": (-6.2, 106.82), "Kota Kinabalu": (5.98, 116.07), "Perth": (-31.95, 115.86), "Sydney": (-33.87, 151.21),
    "Auckland": (-36.85, 174.76), "Cape Town": (-33.92, 18.42), "Windhoek": (-22.56, 17.07), "Lusaka": (-15.39, 28.32),
    "Nairobi": (-1.29, 36.82), "Kampala": (0.35, 32.58), "Maputo": (-25.97, 32.57), "Dar es Salaam": (-6.8, 39.28),
    "Kingston": (17.99, -76.79), "Nassau": (25.05, -77.35), "Georgetown": (6.8, -58.16), "Paramaribo": (5.85, -55.2),
    "Valletta": (35.9, 14.51), "Nicosia": (35.17, 33.36), "Hong Kong": (22.32, 114.17), "Suva": (-18.14, 178.44),
}  # fmt: skip
RIGHT = {
    "Braunschweig": (52.26, 10.52), "Calais": (50.95, 1.86), "Cherbourg": (49.64, -1.62), "Saint-Malo": (48.65, -2.03),
    "Reykjavik": (64.15, -21.94), "Bergen": (60.39, 5.32), "Busan": (35.18, 129.08), "Seoul": (37.57, 126.98),
    "Taipei": (25.03, 121.57), "Shenzhen": (22.54, 114.06), "Zhuhai": (22.27, 113.58), "Kabul": (34.53, 69.17),
    "Zahedan": (29.5, 60.86), "Lhasa": (29.65, 91.14), "Yangon": (16.84, 96.17), "Mandalay": (21.97, 96.08),
    "Vientiane": (18.0, 102.65), "Phnom Penh": (11.56, 104.92), "Hanoi": (21.03, 105.85), "Manila": (14.6, 120.98),
    "Luanda": (-8.84, 13.23), "Lubumbashi": (-11.66, 27.48), "Kigali": (-1.94, 30.06), "Bujumbura": (-3.38, 29.36),
    "Addis Ababa": (9.03, 38.74), "Juba": (4.85, 31.58), "Mogadishu": (2.05, 45.32), "Antananarivo": (-18.88, 47.51),
    "Havana": (23.11, -82.37), "Port-au-Prince": (18.59, -72.31), "San Juan": (18.47, -66.11), "Miami": (25.76, -80.19),
    "Cayenne": (4.92, -52.31), "Caracas": (10.48, -66.9), "Boa Vista": (2.82, -60.67), "Noumea": (-22.27, 166.44),
    "Port Vila": (-17.73, 168.32), "Pago Pago": (-14.28, -170.7), "Gwadar's neighbour Chabahar": (25.29, 60.64),
}  # fmt: skip


@pytest.mark.parametrize(("places", "left"), [(LEFT, True), (RIGHT, False)])
def test_place_says_the_side(places: dict[str, tuple[float, float]], left: bool) -> None:
    wrong = [name for name, place in places.items() if extract_keeps_left(Extract(1, place, 0, 0))[0] != left]
    assert wrong == []


def test_outlines_are_whole() -> None:
    assert [name for name, outline in LEFT_HAND.items() if not shapely.Polygon(outline).is_valid] == []


@pytest.mark.parametrize("clockwise", [True, False])
@pytest.mark.parametrize("place", [LEFT["London"], RIGHT["Calais"]])
def test_roundabouts_go_before_the_place(tmp_path: Path, clockwise: bool, place: tuple[float, float]) -> None:
    closed: Way = ([*range(1, 9), 1], {"highway": "primary", "junction": "roundabout"})
    half: Way = ([1, 2, 3, 4, 5], {"highway": "primary", "junction": "roundabout"})
    text = document(ring(1, 8, 20.0, clockwise), [closed, half], lat=place[0], lon=place[1])
    extract = read_extract(write(tmp_path, text), Path("town.osm"))
    assert (extract.clockwise, extract.counterclockwise) == ((2, 0) if clockwise else (0, 2))
    left, why = extract_keeps_left(extract)
    assert left == clockwise
    assert why.startswith("as 2 of 2 roundabouts")


def test_roundabouts_that_disagree_say_nothing() -> None:
    assert extract_keeps_left(Extract(1, LEFT["London"], 3, 2)) == (True, "as in Great Britain and Ireland")
    assert extract_keeps_left(Extract(1, RIGHT["Calais"], 3, 2)) == (False, "as in most countries")

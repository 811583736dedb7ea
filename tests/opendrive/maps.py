"""Small OpenDRIVE maps, written out."""

from pathlib import Path

LINE = '<geometry s="0" x="0" y="0" hdg="0" length="100"><line/></geometry>'
TMERC = "+proj=tmerc +lat_0=52 +lon_0=10 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs"


def lane(number: int, width: str | float = 3.5, kind: str = "driving", inside: str = "") -> str:
    wide = width if isinstance(width, str) else f'<width sOffset="0" a="{width}" b="0" c="0" d="0"/>'
    return f'<lane id="{number}" type="{kind}" level="false">{wide}{inside}</lane>'


def section(left: str = "", right: str = "", s: float = 0.0) -> str:
    sides = "".join(f"<{side}>{lanes}</{side}>" for side, lanes in (("left", left), ("right", right)) if lanes)
    return f'<laneSection s="{s}"><center><lane id="0" type="none"/></center>{sides}</laneSection>'


def road(
    lanes: str,
    geometry: str = LINE,
    length: float = 100.0,
    *,
    number: str = "1",
    kind: str = "",
    offset: str = "",
    lateral: str = "",
    rule: str = "RHT",
) -> str:
    return (
        f'<road name="" length="{length}" id="{number}" junction="-1" rule="{rule}">{kind}'
        f"<planView>{geometry}</planView><lateralProfile>{lateral}</lateralProfile>"
        f"<lanes>{offset}{lanes}</lanes></road>"
    )


def document(*roads: str, reference: str | None = TMERC, header: str = "") -> str:
    geo = "" if reference is None else f"<geoReference><![CDATA[{reference}]]></geoReference>"
    top = f'<header revMajor="1" revMinor="4">{geo}{header}</header>'
    return f'<?xml version="1.0"?><OpenDRIVE>{top}{"".join(roads)}</OpenDRIVE>'


def write(folder: Path, text: str, name: str = "map.xodr") -> Path:
    path = folder / name
    path.write_text(text)
    return path


TWO_WAY = section(lane(1), lane(-1))

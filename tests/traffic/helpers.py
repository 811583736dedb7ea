from pathlib import Path

CAR = '<vType id="car" sigma="0.5"/>'
ROUTE = '<route edges="A0B0 B0C0"/>'
TRIP = f'<vehicle id="v" type="car" depart="0">{ROUTE}</vehicle>'


def listing(folder: Path) -> dict[str, tuple[int, int]]:
    """Size and time of change of everything in `folder`."""
    return {str(path): (path.stat().st_size, path.stat().st_mtime_ns) for path in folder.rglob("*")}


def names(frames):
    """Ids of the vehicles on the road in each frame, followed through departures and leavings alone."""
    owners, seen = {}, []
    for frame in frames:
        for row in frame.left:
            del owners[row]
        for departure in frame.departures:
            assert departure.row not in owners
            owners[departure.row] = departure.vehicle_id
        assert frame.rows.tolist() == sorted(owners)
        seen.append([owners[row] for row in frame.rows])
    return seen

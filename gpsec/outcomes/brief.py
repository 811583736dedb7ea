"""What a run has found, in at most a dozen lines: what one learns in ten seconds."""

import textwrap
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from gpsec.outcomes.concentration import gatherings
from gpsec.outcomes.paired import named_together
from gpsec.outcomes.ranking import Ranking, Standing, rankings
from gpsec.outcomes.reading import bootstrap_of, read_manifests, read_pooled
from gpsec.outcomes.tables import read_table

# With a heading, what `gpsec show` gives, and where the report is, fifteen.
MOST_LINES = 12
_HEADING = "Out of their lane, mean share of the attacks on a vehicle that act across the road"


def print_brief(out: Path, console: Console) -> None:
    """Print two lines for each scenario and sensor profile of the run in `out`, one where there are many.

    Undefended, the best group of defences, how long before the line they see an attack, and what they cost; and the
    street on which departures gather, where there is one.
    """
    tables = {name: read_pooled(out, name) for name in ("detection", "safety")}
    tables |= {name: read_table(out, name) for name in ("events", "streets", "places")}
    found = rankings(tables, bootstrap_of(read_manifests(out)[0]))
    streets = [[f"  {one.sentence()}" for one in gatherings(tables, ranking)[:1]] for ranking in found]
    for line in [_HEADING, *_fitting(found, streets, console.width), f"All tables: gpsec show {out} tables"]:
        console.print(line, markup=False, highlight=False)


def _fitting(found: Sequence[Ranking], streets: Sequence[list[str]], width: int) -> list[str]:
    """Return the lines of all, or fewer for each where these are too many; costs go first, then `streets`."""
    none: Sequence[list[str]] = [[]] * len(found)
    for lines_of, further in ((_both, streets), (_first, streets), (_first, none)):
        told = zip(found, further, strict=True)
        lines = [line for ranking, street in told for line in _filled([*lines_of(ranking), *street], width)]
        if len(lines) <= MOST_LINES:
            return lines
    return [*lines[: MOST_LINES - 1], "and more: gpsec show"]


def _both(ranking: Ranking) -> list[str]:
    return [*_first(ranking), *([_second(ranking)] if ranking.best else [])]


def _first(ranking: Ranking) -> list[str]:
    name = f"{ranking.scenario} · {ranking.profile}"
    if not ranking.best:
        return [f"{name}: not judged: {ranking.note}"]
    plain = ranking.undefended
    said = [f"{name} ({ranking.vehicles} vehicles):"]
    if plain is not None:
        said.append(f"{percent(plain.share)} undefended;")
    return [" ".join([*said, best_group(ranking)])]


def best_group(ranking: Ranking, most: int = 2) -> str:
    """Say which defences are best, and with what: one that is better than all others, or some that are as good."""
    group = [ranking.standings[name] for name in ranking.best]
    if ranking.winner:
        return f"{percent(group[0].share)} ({_interval(group[0])}) with {ranking.winner}, better than every other"
    names = named_together(ranking.best, most)
    share = extent([each.share for each in group], _hundredths, " %")
    return f"{share} with {names} ({'no difference' if ranking.helps else 'none can be told apart from no defence'})"


def _second(ranking: Ranking) -> str:
    group = [ranking.standings[name] for name in ranking.best]
    alarms = extent([each.false_alarms_per_h for each in group], "{:.2f}".format)
    minutes = extent([each.without_gnss_min_per_h for each in group], "{:.2f}".format)
    cost = f"hourly {alarms} false alarms (in {ranking.vehicle_hours:.1f} h), {minutes} min without GNSS"
    seen = [each for each in group if each.in_time_share > 0.0]
    if not seen:
        return f"  no alarm before the line; {cost}"
    share = extent([each.in_time_share for each in seen], _hundredths, " %")
    lead = extent([each.before_line_s for each in seen], "{:.1f}".format, " s")
    return f"  alarm before the line: {share}, by {lead}; {cost}"


def extent(values: Sequence[float], form: Callable[[float], str], unit: str = "") -> str:
    """Return a figure of a group: one, or the smallest and the largest; a dash where it has none."""
    known = [value for value in values if not np.isnan(value)]
    if not known:
        return "–"
    low, high = form(min(known)), form(max(known))
    return f"{high}{unit}" if low == high else f"{low} to {high}{unit}"


def percent(share: float) -> str:
    """Return a share in per cent, small ones with a decimal."""
    return f"{_hundredths(share)} %"


def _hundredths(share: float) -> str:
    return f"{100.0 * share:.{0 if share >= 0.0995 or share == 0.0 else 1}f}"


def _interval(standing: Standing) -> str:
    return f"{percent(standing.low)} – {percent(standing.high)}"


def _filled(lines: Sequence[str], width: int) -> list[str]:
    return [part for line in lines for part in textwrap.wrap(line, width, subsequent_indent="    ")]

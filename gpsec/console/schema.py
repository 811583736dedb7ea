"""`gpsec schema`: what an editor needs to complete and check a gpsec.toml."""

import json


def schema() -> None:
    """Print the JSON Schema of gpsec.toml, with which an editor completes and checks it.

    \b
    Examples:
      gpsec schema > gpsec.schema.json     (and in gpsec.toml, as the first line: #:schema ./gpsec.schema.json)
    """  # noqa: D301
    from gpsec.scenario.schema import json_schema

    print(json.dumps(json_schema(), indent=2, ensure_ascii=False))

"""What all sections of `gpsec.toml` share."""

from typing import Any

from pydantic import BaseModel, BeforeValidator, ConfigDict


class Section(BaseModel):
    """Base of every section: frozen, unknown keys are errors, nothing is converted silently."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def _none_is_unset(value: Any) -> Any:
    return None if value == "none" else value


# TOML has no null, so that the bare word `none` takes back what a file has set.
Unset = BeforeValidator(_none_is_unset)

"""The responses that a defence can have. A new one is a file and a line here."""

from gpsec.core.registry import Registry, subclass_named
from gpsec.localization.responses import (
    CameraUkf,
    ConsiderUkf,
    DeadReckoning,
    Gate,
    NoResponse,
    Response,
    Rollback,
    Ukf5,
    Ukf5Rollback,
)

_OWN: tuple[type[Response], ...] = (
    NoResponse,
    Gate,
    DeadReckoning,
    CameraUkf,
    Rollback,
    ConsiderUkf,
    Ukf5,
    Ukf5Rollback,
)
RESPONSES: Registry[type[Response]] = Registry(
    "response",
    "gpsec.responses",
    {response.name: response for response in _OWN},
    subclass_named(Response),
)

"""The responses that a defence can have. A new one is a file and a line here."""

from gpsec.core.registry import Registry, subclass_named
from gpsec.localization.camera_ukf import CameraUkf
from gpsec.localization.dead_reckoning import DeadReckoning
from gpsec.localization.no_response import NoResponse
from gpsec.localization.responses import Response
from gpsec.localization.rollback import Rollback
from gpsec.localization.ukf5 import Ukf5
from gpsec.localization.ukf5_rollback import Ukf5Rollback

RESPONSES: Registry[type[Response]] = Registry(
    "response",
    "gpsec.responses",
    {response.name: response for response in (NoResponse, DeadReckoning, CameraUkf, Rollback, Ukf5, Ukf5Rollback)},
    subclass_named(Response),
)

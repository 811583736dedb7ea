"""The section `detection`, and the defences: who watches, and what the vehicle does on an alarm."""

from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from gpsec.core.errors import shown
from gpsec.scenario import choices
from gpsec.scenario.base import Section, Unset
from gpsec.types.points import HEADLINE_RATE, PER_SAMPLE, point_name


class DetectionSection(Section):
    """Who watches.

    Attributes:
        detectors: those that are scored (`gpsec list detectors`), in the order of the tables.
        rates: false-alarm rates, per vehicle-hour or per sample, at which each of them is scored, one at least; see
            `defences.rate`.
        monitor: how far the monitor of `joint` and its like adapts to sensors that are noisier than stated: `R2` where
            an attacker counts, `R3`, further, where maps are poor.
        models: folder of the models, as `gpsec train --out` wrote it; relative to the scenario's folder, in a flag to
            the current one; unset takes those that gpsec comes with.
    """

    detectors: tuple[str, ...] = Field(
        ("chi_square", "cusum", "isolation_forest", "lstm_glr", "innovation", "joint"), strict=False
    )
    rates: tuple[str, ...] = Field((HEADLINE_RATE, PER_SAMPLE), strict=False)
    monitor: Literal["R2", "R3"] = "R2"
    models: Annotated[str | None, Unset] = None

    @field_validator("detectors")
    @classmethod
    def _known_once(cls, names: tuple[str, ...]) -> tuple[str, ...]:
        for position, name in enumerate(names):
            choices.require_known("detector", name, choices.detectors())
            if name in names[:position]:
                raise ValueError(f"'{shown(name)}' is listed twice")
        return names

    @field_validator("rates")
    @classmethod
    def _calibrated(cls, rates: tuple[str, ...]) -> tuple[str, ...]:
        if not rates:
            raise ValueError(f"expected at least one rate, such as '{HEADLINE_RATE}', found none")
        for position, rate in enumerate(rates):
            choices.require_rate(rate)
            if rate in rates[:position]:
                raise ValueError(f"'{shown(rate)}' is listed twice")
        return rates


class Defence(Section):
    """A detector and what the vehicle does on its alarm.

    Attributes:
        detector: one of `detection.detectors`; or `told`, which is told at once when an attack begins and ends; or
            `never`, which gives no alarm.
        response: what replaces GNSS while the alarm lasts (`gpsec list responses`).
        rate: of the detector's false alarms, which its threshold is calibrated to: `0.1/h`, ten vehicle-hours for each,
            is what one would drive with; `1e-3/sample` is what the paper's tables are set beside. In tables another
            rate than `0.1/h` is part of the name: `lstm@1e-3/sample+ukf`.
    """

    detector: str
    response: str
    rate: str = HEADLINE_RATE

    @property
    def point(self) -> str:
        """Name of its detector at its rate."""
        return point_name(self.detector, self.rate)

    @property
    def name(self) -> str:
        """Name of the defence in tables: ``detector+response``, or ``detector@rate+response``."""
        return f"{self.point}+{self.response}"

    @field_validator("rate")
    @classmethod
    def _calibrated(cls, rate: str) -> str:
        return choices.require_rate(rate)

    @model_validator(mode="after")
    def _rate_means_something(self) -> Self:
        if self.rate != HEADLINE_RATE and not choices.has_rate(self.detector):
            raise ValueError(f"'{shown(self.detector)}' has no calibrated threshold, and so no rate")
        return self

    @field_validator("detector")
    @classmethod
    def _known_detector(cls, name: str) -> str:
        if name == "oracle":
            raise ValueError("the detector 'oracle' is called 'told' now; expected 'told'")
        return choices.require_known("detector", name, [*choices.BOUNDS, *choices.detectors()])

    @field_validator("response")
    @classmethod
    def _known_response(cls, name: str) -> str:
        return choices.require_known("response", name, choices.responses())

"""What all sections of a configuration have in common, and how their own checks report what they find."""

from __future__ import annotations

from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, ConfigDict, Field

from archsim.units import Bytes

Size = Annotated[Bytes, Field(ge=1, le=2**40)]
Small = Annotated[int, Field(ge=1, le=4096)]
Count = Annotated[int, Field(ge=1, le=1_000_000)]
Coordinate = Annotated[float, Field(ge=-1e9, le=1e9)]
Vector = Annotated[tuple[Coordinate, Coordinate, Coordinate], Field(strict=False)]
_NAME, _COMPONENT, _PATH = (
    r"^[A-Za-z0-9][A-Za-z0-9 _.+-]{0,99}$",
    r"^[A-Za-z_][A-Za-z0-9_-]{0,99}$",
    r"^[^\s=.]+(\.[^\s=.]+)*$",
)
SHAPES = {  # pattern -> what it says, in words
    _NAME: "a name of letters a to z, digits, spaces and any of _ . + -",
    _COMPONENT: "a name of letters a to z, digits, '_' and '-'",
    _PATH: "a dotted path such as machine.components.l2.size",
}
Name = Annotated[str, Field(pattern=_NAME)]
ComponentName = Annotated[str, Field(pattern=_COMPONENT)]
DottedPath = Annotated[str, Field(pattern=_PATH)]  # {a,b} in it stands for several keys


class Section(BaseModel):
    """A mapping of known keys. Frozen; unknown keys, NaN, infinity and mixed-up types are errors."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Finding(NamedTuple):
    """Something wrong, at a path of keys inside the section that was checked."""

    path: tuple[str | int, ...]
    what: str
    hint: str | None = None


class FindingsError(ValueError):
    """Everything that the check of a section found. ValueError, so that pydantic collects it."""

    def __init__(self, findings: list[Finding]):
        self.findings = findings
        lines = [f"{'.'.join(str(part) for part in each.path)}: {each.what}" for each in findings]
        super().__init__("\n".join(lines))


def report(findings: list[Finding]) -> None:
    """Raises FindingsError unless there is nothing to report."""
    if findings:
        raise FindingsError(findings)


def is_power_of_two(number: int) -> bool:
    """True for 1, 2, 4, ..."""
    return number > 0 and number & (number - 1) == 0


def key_of(section: Any, key: str) -> str | None:
    """The text under a key of a mapping or section, for telling kinds of sections apart."""
    value = section.get(key) if isinstance(section, dict) else getattr(section, key, None)
    return value if isinstance(value, str) else None

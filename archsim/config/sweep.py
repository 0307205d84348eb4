"""The sweep section: the run that a sweep starts from, and blocks of parameters."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag, model_validator

from archsim.config.section import DottedPath, Finding, Name, Section, report

KINDS = ("grid", "zip", "list", "random")

Values = Annotated[tuple[Any, ...], Field(strict=False, min_length=1, max_length=10_000)]
Whole = Annotated[int, Field(ge=0, le=2**32 - 1)]


def _number_tag(value: Any) -> str:
    return "<int>" if isinstance(value, int) else "<float>"


def _drawn_tag(value: Any) -> str:
    return "<RangeConfig>" if isinstance(value, dict | Section) else "<list>"


Number = Annotated[
    Annotated[int, Tag("<int>")] | Annotated[float, Tag("<float>")], Discriminator(_number_tag)
]


class RangeConfig(Section):
    """Numbers between two bounds, both included."""

    low: Number  # the smallest
    high: Number  # the largest
    scale: Literal["linear", "powers_of_two"] = "linear"  # powers_of_two: low times 1, 2, 4 ...

    @model_validator(mode="after")
    def _check(self) -> RangeConfig:
        found = []
        if self.high < self.low:
            found.append(Finding(("high",), f"must be at least low, {self.low}"))
        if self.scale == "powers_of_two" and self.low <= 0:
            found.append(Finding(("low",), "must be above 0 for powers of two"))
        report(found)
        return self


Drawn = Annotated[
    Annotated[RangeConfig, Tag("<RangeConfig>")] | Annotated[Values, Tag("<list>")], Discriminator(_drawn_tag)
]


class RandomConfig(Section):
    """Points drawn at random; the same seed draws the same points."""

    count: Annotated[int, Field(ge=1, le=100_000)]  # points
    seed: Whole  # of the draws
    values: Annotated[dict[DottedPath, Drawn], Field(min_length=1)]  # a list to choose from, or a range


class BlockConfig(Section):
    """One block of parameters. The points of a sweep are the product of its blocks, in order."""

    grid: Annotated[dict[DottedPath, Values], Field(min_length=1)] | None = None  # all combinations
    zip: Annotated[dict[DottedPath, Values], Field(min_length=1)] | None = (
        None  # first with first, second with second
    )
    list: Annotated[tuple[dict[DottedPath, Any], ...], Field(strict=False, min_length=1)] | None = (
        None  # one by one
    )
    random: RandomConfig | None = None  # drawn
    when: dict[str, Any] | None = None  # only for points that have these values, or one of a list of values

    @property
    def kind(self) -> str:
        return next(kind for kind in KINDS if getattr(self, kind) is not None)

    @model_validator(mode="after")
    def _check(self) -> BlockConfig:
        given = [kind for kind in KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            report([Finding((), f"must have one of {', '.join(KINDS)}, not {len(given)} of them")])
        if self.zip is not None and len({len(values) for values in self.zip.values()}) > 1:
            lengths = ", ".join(str(len(values)) for values in self.zip.values())
            report([Finding(("zip",), f"all lists must be equally long; they have {lengths} values")])
        return self


class SweepConfig(Section):
    """A sweep."""

    name: Name  # what the sweep is called; names its folder
    run: str  # the run that every point starts from: a file, or the name of a packaged one
    set: dict[DottedPath, Any] = Field(default_factory=dict)  # for every point
    parameters: Annotated[
        tuple[BlockConfig, ...], Field(strict=False, min_length=1, max_length=100)
    ]  # blocks
    seeds: Annotated[int, Field(ge=1, le=1000)] = 1  # every point this often, with seeds 0, 1, 2 ...
    metrics: Annotated[tuple[str, ...], Field(strict=False)] = ()  # statistics to minimise; () for all cycles

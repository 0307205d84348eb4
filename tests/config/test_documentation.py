"""Every key is documented where it is declared; the schema accepts what loads and refuses what does not."""

from typing import Annotated

import jsonschema
import pytest
import yaml
from pydantic import Field

from archsim import resources
from archsim.config.documentation import (
    PARTS,
    documented_schema,
    editor_schema,
    field_comments,
    sections_below,
)
from archsim.config.run import RunConfig
from archsim.config.section import Section
from archsim.config.sweep import SweepConfig
from archsim.config.walkthrough import WalkthroughConfig
from archsim.errors import ArchsimError
from archsim.units import Bytes

FILES = [
    (part, path)
    for part in PARTS
    for path in sorted((resources.root() / "configs" / f"{part}s").glob("*.yaml"))
]


class Sample(Section):
    """Something. And more."""

    # above
    # and again
    first: int
    second: Annotated[Bytes, Field(ge=2)] = 4  # behind
    third: str


@pytest.mark.parametrize(
    "section",
    [*sections_below(RunConfig), *sections_below(SweepConfig), *sections_below(WalkthroughConfig)],
    ids=lambda section: section.__name__,
)
def test_every_key_has_a_comment(section):
    assert set(section.model_fields) == set(field_comments(section))


def test_comments_above_and_behind_are_found():
    assert field_comments(Sample) == {"first": "above and again", "second": "behind"}


def test_the_schema_has_meaning_unit_and_range():
    second = documented_schema(Sample)["properties"]["second"]

    assert (second["description"], second["unit"], second["minimum"]) == ("behind", "B", 2)


@pytest.mark.parametrize(("part", "path"), FILES, ids=[path.name for _, path in FILES])
def test_packaged_files_fit_the_schema(part, path):
    jsonschema.validate(yaml.safe_load(path.read_text()), editor_schema(part))


@pytest.mark.parametrize(
    "text",
    ["nmae: x", "machine: {components: {l2: {kind: cache, siez: 3}}}", "model: fast", "seed: -1", "scene: 3"],
)
def test_mistakes_do_not_fit(text):
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(yaml.safe_load(text), editor_schema("run"))


def test_an_unknown_part_is_named():
    with pytest.raises(ArchsimError, match="did you mean 'machine'"):
        editor_schema("machin")

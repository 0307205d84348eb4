"""`archsim statistics`: the whole reference, or the lines that a word is in."""

from typer.testing import CliRunner

from archsim.cli.app import app
from archsim.run.catalogue import reference


def test_the_reference_is_printed():
    assert CliRunner().invoke(app, ["statistics"]).stdout == reference()


def test_a_word_finds_its_lines():
    lines = CliRunner().invoke(app, ["statistics", "forwarded_bytes"]).stdout.splitlines()

    assert lines == ["{phase}.dram.forwarded_bytes [bytes]: Bytes of those reads."]


def test_a_word_that_is_nowhere_is_an_error_with_a_hint():
    result = CliRunner().invoke(app, ["statistics", "bus_precent"])

    assert result.exit_code == 2
    assert "did you mean 'bus_percent'?" in result.stderr

"""Help of a command with many options: sections of options that belong together, in the order of their declaration."""

from __future__ import annotations

from typing import Any

from typer.core import TyperCommand, TyperOption

OTHER = "Options"


class Sectioned(TyperCommand):
    """A command whose options are listed by their `rich_help_panel`."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """The arguments, then each section."""
        sections: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                is_option = isinstance(parameter, TyperOption)
                title = (getattr(parameter, "rich_help_panel", None) or OTHER) if is_option else "Arguments"
                sections.setdefault(title, []).append(record)
        for title in sorted(sections, key=lambda title: (title != "Arguments", title == OTHER)):
            with formatter.section(title):
                formatter.write_dl(sections[title])

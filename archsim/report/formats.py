"""How numbers look to people, on a page and on a terminal."""

from __future__ import annotations

import json
from typing import Any


def number(value: Any) -> str:
    """Whole numbers with separators, others with four significant digits, a range as `75 - 118`."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list | tuple):
        return " - ".join(number(item) for item in value)
    if not isinstance(value, int | float):
        return str(value)
    if value != value or value in (float("inf"), float("-inf")):
        return "-"
    if isinstance(value, int) or (float(value).is_integer() and abs(value) >= 1000):
        return f"{int(value):,}"
    return f"{value:,.0f}" if abs(value) >= 10_000 else f"{value:,.4g}"


def setting(value: Any) -> str:
    """A value of a configuration as it is written there: `[64, 48]`, `null`, `2 KiB`."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False, default=str)


def percent(value: float | None) -> str:
    """A signed error in per cent."""
    if value is None:
        return "-"
    if value == 0:
        return "0 %"
    return f"{value:+.0f} %" if abs(value) >= 100 else f"{value:+.1f} %"


def words(name: str) -> str:
    """A dotted or underscored name as words."""
    return name.replace(".", ": ").replace("_", " ")

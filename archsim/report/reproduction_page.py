"""The report of a paper's reproduction: its tables, printed beside ours, then what the machine did."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from archsim.config.explain import origins
from archsim.report import figures
from archsim.report.advice import advice
from archsim.report.page import render, shadow_caption, shadow_uri
from archsim.report.run_page import cache_outcomes, roof_of, row_outcomes
from archsim.report.statistics import Phase, phases
from archsim.report.tables import FAIR_PERCENT, GOOD_PERCENT, grade, tables
from archsim.reproduce.cells import CALIBRATED, EXACT, KINDS, PREDICTED, Cell, Paper
from archsim.reproduce.reproduction import Reproduction

Outcomes = Callable[[Sequence[Phase]], dict[str, dict[str, float]]]


def reproduction_report(
    paper: Paper, reproduction: Reproduction, manifest: Mapping[str, Any], links: Mapping[str, str]
) -> str:
    """The page as HTML text; `links` lead to the rows' own pages. It needs nothing but itself."""
    cells, results = reproduction.cells, {name: row.result for name, row in reproduction.rows.items()}
    ran = {f"{name}: {phase.name}": phase for name, result in results.items() for phase in phases(result)}
    return render(
        "reproduction.html.j2",
        timed=bool(ran),
        title=paper.title,
        subtitle=f"Reproduced by archsim {manifest['archsim']}, {manifest['wall_seconds']:g} s of wall time",
        cards=summary(cells),
        tables=tables(paper, cells),
        kinds=KINDS,
        good=GOOD_PERCENT,
        fair=FAIR_PERCENT,
        grade=grade,
        pictures=reproduction.pictures,
        stalls=figures.stall_stack(ran) if ran else "",
        advice=[(name, advice(phase)) for name, phase in ran.items()],
        roofline=figures.roofline({name: roof for name, phase in ran.items() if (roof := roof_of(phase))}),
        outcomes=_outcomes(cache_outcomes, ran, "lookups", "caches"),
        dram=_outcomes(row_outcomes, ran, "requests", "rows"),
        links=links,
        shadows=[
            (f"{name}: {shadow_caption(r.shadow)}", shadow_uri(r.shadow)) for name, r in results.items()
        ],
        checks=[
            *(
                check._replace(name=f"{name}: {check.name}")
                for name, r in results.items()
                for check in r.checks
            ),
            *reproduction.checks,
        ],
        origins={
            **{name: origins(row.loaded) for name, row in reproduction.rows.items()},
            **reproduction.origins,
        },
        manifest=manifest,
    )


def summary(cells: Sequence[Cell]) -> list[tuple[str, str]]:
    """(number, what it counts) of the cards on top."""
    cards = []
    for kind in KINDS:
        own = [cell for cell in cells if cell.kind == kind]
        errors = [abs(cell.error_percent) for cell in own if cell.error_percent is not None]
        if kind == PREDICTED and errors:
            near = sum(error <= GOOD_PERCENT for error in errors)
            cards.append(
                (f"{statistics.median(errors):.1f} %", f"median error of {len(own)} predicted cells")
            )
            cards.append((f"{near} of {len(errors)}", f"predicted cells within {GOOD_PERCENT:g} %"))
        elif kind == EXACT and own:
            cards.append(
                (f"{sum(error == 0 for error in errors)} of {len(own)}", "exact cells that are equal")
            )
        elif kind == CALIBRATED and errors:
            cards.append(
                (f"{statistics.median(errors):.1f} %", f"median error of {len(own)} calibrated cells")
            )
    return cards


def _outcomes(outcomes: Outcomes, ran: Mapping[str, Phase], unit: str, key: str) -> str:
    """A figure of the outcomes of phases that carry the names of their rows; nothing without phases."""
    if not ran:
        return ""
    named = [phase._replace(name=name) for name, phase in ran.items()]
    return figures.shares(outcomes(named), figures.OUTCOMES, unit, key)

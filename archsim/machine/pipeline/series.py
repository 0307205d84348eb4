"""What both models of a pipeline tell at regular intervals."""

from __future__ import annotations

from archsim.machine.pipeline.counters import PipelineCounters
from archsim.machine.series import Sample, sample_of
from archsim.model.unit.spec import Slot


def pipeline_sample(cycle: int, counters: PipelineCounters) -> Sample:
    """The sample that counters are."""
    memory = sample_of(cycle, counters.memory)
    return memory._replace(busy=counters.unit_slots[:, Slot.BUSY], stayed=counters.channel_stayed)

"""Papers' tables regenerated: one module a paper, each printed number beside ours."""

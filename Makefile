# `make reproduce` and `make test` need nothing but Python 3.11 or newer and make: they set up .venv themselves.

PYTHON ?= python3
BIN := .venv/bin
PYTEST := $(BIN)/python -m pytest -q

.PHONY: reproduce test test-slow lint docs clean

reproduce: .venv/installed
	$(BIN)/archsim reproduce johnson2004

test: lint
	$(PYTEST) -m "not slow" -n 2 --dist worksteal
	NUMBA_BOUNDSCHECK=1 $(PYTEST) -p no:cacheprovider tests/test_tiny.py tests/model
	NUMBA_DISABLE_JIT=1 $(PYTEST) -p no:cacheprovider tests/test_tiny.py tests/raster tests/shadow/test_grid.py
	$(BIN)/archsim run configs/runs/tiny.yaml --out build/tiny

test-slow: .venv/installed
	$(PYTEST) -m slow

lint: .venv/installed
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy

docs: .venv/installed
	$(BIN)/sphinx-build -q -W -C -D project=archsim -D extensions=myst_parser \
		-D suppress_warnings=myst.xref_missing,myst.header archsim/docs build/docs
	@echo "open build/docs/index.html"

clean:
	rm -rf .venv build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

# Installs again only when pyproject.toml has changed; the package itself is used from here (editable).
.venv/installed: pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "archsim needs Python 3.11 or newer and '$(PYTHON)' is not. Try: make PYTHON=python3.12 ..."; exit 1; }
	@echo "setting up .venv (a minute or two, once)"
	@test -x $(BIN)/python || $(PYTHON) -m venv .venv
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	@touch $@

# Each target sets itself up in .venv on a machine with python3 (3.11 or newer, with venv) and make.

PYTHON ?= python3
BIN := .venv/bin
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt
LAYERS := analytic engines models reports
# Bytecode, pytest's rewritten tests too, is kept for the processes that tests start.
CACHED := PYTHONDONTWRITEBYTECODE= PYTHONPYCACHEPREFIX=$(CURDIR)/.venv/pycache
# Each process of the tests has a processor: threads of linear algebra would wait for one another.
ALONE := OPENBLAS_NUM_THREADS=1
# Neighbours run in one process, which share what is measured once; who is done takes over some.
PARALLEL := --numprocesses auto --dist worksteal
ARGS ?=

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL:
.PHONY: help validate test test-long check benchmark peers heyoka clean

help:  ## list the targets
	@echo "make TARGET [ARGS='...'] [PYTHON=python3.12]"
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "  %-10s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

validate: .venv/.run  ## run the validation and write its page (ARGS go to `plumbob validate`)
	$(BIN)/plumbob validate $(ARGS)

test: .venv/.develop  ## run the tests but those that take seconds (those too: ARGS='--suite whole')
	$(CACHED) $(ALONE) $(BIN)/python -m pytest $(PARALLEL) --suite short $(ARGS)

test-long: .venv/.develop  ## mutations, the full profile, and a longer search by hypothesis: hours
	$(BIN)/python -m plumbob.tests.validation.mutations
	$(ALONE) $(BIN)/python -m plumbob.tests.commands.hostile
	$(BIN)/python -m pytest --numprocesses auto --profile full --seed $$(date -u +%Y%m%d) \
	  tests/validation tests/site tests/replay tests/closed_forms tests/three_points $(ARGS)
	@$(PIP) --editable '.[robots]'
	@$(PIP) --no-deps 'dm_control>=1.0'  # its model files: nothing of it is imported
	$(BIN)/python -m pytest --numprocesses auto tests/audit --profile full $(ARGS)
	HYPOTHESIS_PROFILE=search $(BIN)/python -m pytest --numprocesses auto --suite all $(ARGS)

check: .venv/.develop  ## ruff, mypy --strict, and the contracts on layers, files and words
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	@mkdir -p .venv/src && ln -sfn ../.. .venv/src/plumbob
	$(BIN)/mypy --strict -p plumbob
	$(BIN)/python -m pytest -q tests/contracts

benchmark: .venv/.peers  ## ratios of times, held to limits (ARGS go to pytest)
	$(CACHED) $(BIN)/python -m pytest tests/benchmarks $(ARGS)

peers: .venv/.peers  ## add the optional engines and integrators to .venv

heyoka: .venv/.heyoka  ## add heyoka and dask, the smallest of them to wait for

clean:  ## remove .venv and everything that a build or a run leaves
	rm -rf .venv build dist *.egg-info plumbob-out MUJOCO_LOG.TXT
	rm -rf .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find $(LAYERS) tests -type d -name __pycache__ -prune -exec rm -rf {} +

.venv/.python: pyproject.toml constraints.txt
	@$(PYTHON) -c '' 2>/dev/null || { echo >&2 \
	  "plumbob: $(PYTHON) is missing: install Python 3.11 or newer (Debian, Ubuntu: apt-get install python3 python3-venv)"; exit 1; }
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo >&2 \
	  "plumbob: $$($(PYTHON) --version) is too old: install Python 3.11 or newer and run make PYTHON=python3.11"; exit 1; }
	@$(PYTHON) -c 'import venv, ensurepip' 2>/dev/null || { echo >&2 \
	  "plumbob: $(PYTHON) has no venv module: install it (Debian, Ubuntu: apt-get install python3-venv)"; exit 1; }
	@if ! $(BIN)/python -m pip --version >/dev/null 2>&1; then \
	  echo "plumbob: making .venv with $$($(PYTHON) --version)"; $(PYTHON) -m venv --clear .venv; fi
	@touch $@

.venv/.run: .venv/.python
	@echo "plumbob: installing plumbob and what it needs into .venv (once; a minute or two)"
	@$(PIP) --editable .
	@touch $@

.venv/.develop: .venv/.python
	@echo "plumbob: installing plumbob and the tools of its tests and checks into .venv (once; a minute or two)"
	@$(PIP) --editable '.[test,check]'
	@touch $@ .venv/.run

.venv/.heyoka: .venv/.python
	@echo "plumbob: installing plumbob, the tools of its tests, heyoka and dask into .venv (once; some 250 MB)"
	@$(PIP) --editable '.[test,check,heyoka,distributed]'
	@touch $@ .venv/.run .venv/.develop

.venv/.peers: .venv/.develop
	@echo "plumbob: installing the optional engines into .venv (once; some 1.4 GB, two to four minutes)"
	@$(PIP) --editable '.[peers]'
	@touch $@

# make demo: install everything into .venv and watch the shipped policy work.   make help: what else there is.
SHELL := bash
.SHELLFLAGS := -euo pipefail -c
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:

VENV := .venv
PYTHON_VERSION := $(shell cat .python-version)
INSTALLED := $(VENV)/.installed
ifneq ($(shell uname -s),Darwin)
export MUJOCO_GL ?= egl
endif
# Tests run in a process for each core, four at most: each takes some 1.5 GB and, with one thread, a core.
TEST_PROCESSES ?= $(shell n=$$(nproc 2>/dev/null || sysctl -n hw.ncpu 2>/dev/null || echo 2); echo $$((n < 4 ? n : 4)))
PYTEST := HF_HUB_OFFLINE=1 OMP_NUM_THREADS=1 $(VENV)/bin/python -m pytest --numprocesses=$(TEST_PROCESSES) --dist=loadfile
# PyTorch, oneDNN, MKL and OpenBLAS then sum in the order in which a processor without AVX-512 does.
AVX2_ALONE := ATEN_CPU_CAPABILITY=avx2 ONEDNN_MAX_CPU_ISA=AVX2 MKL_ENABLE_INSTRUCTIONS=AVX2 OPENBLAS_CORETYPE=Haswell
NUMERICAL_TESTS := tests/test_geometry.py tests/policies/test_muon.py tests/policies/action tests/policies/command/small \
    tests/policies/command/decoding tests/policies/command/test_modeling_llakey_command.py tests/policies/hierarchy/test_rows.py

# Prints the first Python of the version in .python-version that runs, or nothing. PYTHON=... comes first.
define FIND_PYTHON
found=""; \
for candidate in "$${PYTHON:-}" "$$(pyenv which python$(PYTHON_VERSION) 2>/dev/null || true)" python$(PYTHON_VERSION) \
    python3 python "$$(ls -d "$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/$(PYTHON_VERSION)*/bin/python 2>/dev/null | tail -n 1)" \
    "$$(uv python find $(PYTHON_VERSION) 2>/dev/null || true)"; do \
  if [ -n "$$candidate" ] && "$$candidate" -c \
      'import sys; sys.exit("%d.%d" % sys.version_info[:2] != "$(PYTHON_VERSION)")' >/dev/null 2>&1; then \
    found="$$candidate"; break; \
  fi; \
done
endef

.PHONY: help setup demo test test-avx2 fuzz torture check format clean

help:  ## list the targets
	@grep -E '^[a-z0-9-]+:.*## ' Makefile | sed -E 's/^([a-z0-9-]+):.*## (.*)/  make \1\t\2/' | expand -t 18

setup: $(INSTALLED)  ## make .venv with the exact versions of constraints.txt

demo: $(INSTALLED)  ## evaluate the shipped policy on its tasks: a table and videos
	@$(VENV)/bin/llakey demo

test: $(INSTALLED)  ## run every test
	@$(PYTEST)

test-avx2: $(INSTALLED)  ## run the numerical tests as on a processor without AVX-512
	@$(AVX2_ALONE) $(PYTEST) $(NUMERICAL_TESTS)

fuzz: $(INSTALLED)  ## hand in 500 generated wrong inputs; each must be answered with a sentence or put right
	@PYTHONPATH=.:tests HF_HUB_OFFLINE=1 OMP_NUM_THREADS=1 $(VENV)/bin/python -m fuzz.run

torture: $(INSTALLED)  ## kill collecting 20 times here and 10 times on a Ray cluster; count what is lost or doubled
	@PYTHONPATH=.:tests HF_HUB_OFFLINE=1 OMP_NUM_THREADS=1 $(VENV)/bin/python -m torture.run

check: $(INSTALLED)  ## ruff check, ruff format --check, mypy
	@$(VENV)/bin/ruff check .
	@$(VENV)/bin/ruff format --check .
	@$(VENV)/bin/mypy

format: $(INSTALLED)  ## apply ruff's fixes and its format
	@$(VENV)/bin/ruff check --fix .
	@$(VENV)/bin/ruff format .

clean:  ## remove .venv, builds and caches (outputs/ and data/ stay)
	@rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
	@find . -name __pycache__ -type d -prune -exec rm -rf {} +

$(VENV)/bin/python:
	@$(FIND_PYTHON); \
	if [ -n "$$found" ]; then \
	  echo "Making $(VENV) with $$found"; \
	  if command -v uv >/dev/null; then uv venv --quiet --python "$$found" $(VENV); else "$$found" -m venv $(VENV); fi; \
	else \
	  echo "Expected Python $(PYTHON_VERSION) (see .python-version) and found none;" \
	    "install it (for example: uv python install $(PYTHON_VERSION), or pyenv install $(PYTHON_VERSION))" \
	    "or name it: make PYTHON=/path/to/python$(PYTHON_VERSION)." >&2; \
	  exit 1; \
	fi

# The stamp is written last, so that an installation that was cut short is taken up again.
$(INSTALLED): pyproject.toml constraints.txt | $(VENV)/bin/python
	@uv="$$(command -v uv || true)"; \
	if [ -z "$$uv" ]; then \
	  uv=$(VENV)/bin/uv; \
	  [ -x "$$uv" ] || $(VENV)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints.txt uv; \
	fi; \
	"$$uv" pip install --python $(VENV)/bin/python --constraint constraints.txt --editable '.[dev]'
	@touch $@

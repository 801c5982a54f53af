# Two things to type: `make bench` and `make test`. Needs Python 3.11 or later and make; no compiler.
#
#   make bench PYTHON=python3.12     another interpreter
#   make bench OUT=/path/to/folder   another place for the results

PYTHON ?= python3
VENV ?= .venv
OUT ?= results/quick

VERSION := $(shell $(PYTHON) -c 'import sys; print("%d.%d" % sys.version_info[:2])' 2>/dev/null)
# The stamps carry the interpreter's version: another PYTHON makes a new environment.
INSTALLED := $(VENV)/.installed-$(VERSION)
INSTALLED_DEV := $(VENV)/.installed-dev-$(VERSION)

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help bench test environment environment-dev python

help:
	@echo 'make bench   compare a handful of controllers (about a minute, plus the first installation)'
	@echo 'make test    run the tests'
	@echo ''
	@echo 'Both install into $(VENV) with PYTHON=$(PYTHON) first; outside this folder only caches are written.'

bench: $(INSTALLED)
	$(VENV)/bin/torquebench run quick --out '$(OUT)'

# Not `python -m pytest`: that would put this folder on the path and make the rooms importable under a second name.
test: $(INSTALLED_DEV)
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(VENV)/bin/pytest -n auto

environment: $(INSTALLED)

environment-dev: $(INSTALLED_DEV)

python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null || { \
	echo 'torquebench needs Python 3.11 or later; $(PYTHON) is $(or $(VERSION),not there). Name another: make bench PYTHON=python3.11' >&2; exit 1; }

$(INSTALLED): pyproject.toml | python
	$(make_environment)
	$(VENV)/bin/python -m pip install --quiet --editable .
	@touch $@

$(INSTALLED_DEV): pyproject.toml | python
	$(make_environment)
	$(VENV)/bin/python -m pip install --quiet --editable '.[dev]'
	@touch $@ $(INSTALLED)

# Keeps an environment of the same version, replaces one of another.
define make_environment
@[ -e $(VENV)/bin/pip ] && [ -n "$$(ls $(VENV)/.installed-*$(VERSION) 2>/dev/null)" ] || { \
echo 'Making $(VENV) with Python $(VERSION); the libraries take a few minutes the first time.'; \
$(PYTHON) -m venv --clear $(VENV); }
endef

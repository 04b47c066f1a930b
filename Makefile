# make setup    make .venv with relight in it
# make run      open the editor on the sample portrait, or on PHOTO=path
# make test     run the tests
# make lint     check the style
#
# Each does all the set-up that is missing. PYTHON=python3.12 chooses the interpreter .venv is made from.

PYTHON ?= python3
PHOTO ?=
# As it was typed: a name may hold a dollar sign.
override PHOTO := $(value PHOTO)
export PHOTO

BIN := .venv/bin
READY := .venv/.ready

.PHONY: setup run test lint

setup: $(READY)

run: $(READY)
	@$(BIN)/relight $${PHOTO:+"$$PHOTO"}

test: $(READY)
	$(BIN)/python -m pytest -q -n auto --maxprocesses 4 --dist loadfile

lint: $(READY)
	$(BIN)/ruff check .

$(READY): pyproject.toml requirements.lock
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "relight needs Python 3.11 or newer, and $(PYTHON) is not: name one, as in  make PYTHON=python3.12" >&2; \
	  exit 1; }
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --requirement requirements.lock
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation --editable .
	@touch $@

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed
SCENARIO ?= karasuyama_weekday
UNIT_LINES ?= 250
FILE_LINES ?= 500

# What one command has compiled, the next one reads, also where the environment would have no bytecode kept.
unexport PYTHONDONTWRITEBYTECODE

# Tests of compiled laws; those of the slice take seconds even when they are interpreted.
LAWS := tests/vehicle tests/onboard/driving tests/onboard/localisation tests/onboard/test_tick.py
LAWS_SLICE := $(addprefix tests/vehicle/test_,resistance.py traction.py brakes.py response.py)

.PHONY: install demo wheel test browser nightly interpreted check bench nets docs sightings pictures studies reproductions format clean

install: $(STAMP)

# By uv, in a third of pip's time; by pip where uv finds no index, as it does not read pip's settings.
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check
define installed
$(INSTALL) uv && $(BIN)/uv pip install --quiet --compile-bytecode --python $(BIN)/python -e '.[$(1)]' || $(INSTALL) -e '.[$(1)]'
endef

$(STAMP): pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(call installed,dev)
	touch $(STAMP)

demo: install
	$(BIN)/branchline run karasuyama_weekday --out runs/karasuyama_weekday

# With code compiled for any processor inside; it serves this minor version of Python on this platform.
wheel: install
	$(BIN)/python -m documents.wheel

# The interpreted slice beside the others: alone at their end it would leave a core idle.
TESTS := test-compiled test-interpreted
.PHONY: $(TESTS)
test: install
	$(MAKE) --no-print-directory -j 2 $(TESTS)

test-compiled:
	$(BIN)/python -m pytest -n 2 --dist loadfile

test-interpreted:
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -p no:cacheprovider $(LAWS_SLICE)

# The report in Chromium, which is installed with the system's packages where it is missing; frames a second are printed.
browser: install
	command -v chromium >/dev/null || command -v chromium-browser >/dev/null || (apt-get update && apt-get install -y --no-install-recommends chromium)
	$(call installed,browser)
	$(BIN)/python -m pytest tests/browser -m browser

# What is too long for every change, many examples of what every run tries few of, and the laws as Python runs them,
# with their coverage.
nightly: install interpreted
	$(BIN)/python -m pytest -n 2 --dist loadfile -m "nightly or hypothesis" --hypothesis-profile many

interpreted: install
	NUMBA_DISABLE_JIT=1 $(BIN)/python -m pytest -n 2 --dist loadfile $(LAWS) \
		--cov=vehicle --cov=onboard.driving --cov=onboard.localisation --cov=onboard.tick --cov-report=term-missing:skip-covered

# Two at a time: the checkers of types take the longest.
CHECKS := check-mypy check-pyright check-structure check-generated check-style
.PHONY: $(CHECKS)
check: install
	$(MAKE) --no-print-directory -j 2 $(CHECKS)

check-mypy:
	$(BIN)/mypy

check-pyright:
	$(BIN)/basedpyright

check-structure:
	$(BIN)/python -m documents.structure --unit-lines $(UNIT_LINES) --file-lines $(FILE_LINES)

check-generated:
	$(BIN)/python -m documents.generated

check-style:
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .

bench: install
	$(BIN)/branchline bench $(SCENARIO)

docs: install
	$(BIN)/python -m documents.busy_line
	$(BIN)/python -m documents.desk_protocol
	$(BIN)/python -m documents.files
	$(BIN)/python -m documents.interlocking
	$(BIN)/python -m documents.journal
	$(BIN)/python -m documents.faults
	$(BIN)/python -m documents.losses
	$(BIN)/python -m documents.reproductions
	$(BIN)/python -m documents.safety
	$(BIN)/python -m documents.sensors
	$(BIN)/python -m documents.substitute
	$(BIN)/python -m documents.tables
	$(BIN)/python -m documents.second_loop

# What the quick notebooks of docs/notebooks show.
.PHONY: notebooks
notebooks: install
	$(BIN)/python -m documents.notebooks

# README.md and docs/ as pages that open offline, in site/.
.PHONY: site
site: install
	$(BIN)/python -m mkdocs build --quiet

# What cameras see in every light, from rendered images: minutes, and other samples on another machine's arithmetic.
sightings: install
	$(BIN)/python -m documents.sightings

pictures: install
	$(BIN)/python -m documents.pictures
	$(BIN)/python -m documents.desk_pictures $(or $(DESK_PICTURES),runs/desk-pictures)

# The figures and pictures of docs/studies, from seventeen days, which are run where RUNS does not have them: minutes.
RUNS ?= runs
studies: install
	$(BIN)/python -m documents.studies $(RUNS)

# What docs/reproductions.md shows, by running every reproduction, or those of NAMES, anew: half an hour for all.
NAMES ?=
reproductions: install
	$(BIN)/python -m documents.reproductions --run $(NAMES)

nets: install
	$(BIN)/python -m sumo_cfg.build

format: install
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

clean:
	rm -rf $(VENV) build dist runs site *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

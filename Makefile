# One-time set-up is a dependency of every job: a fresh clone needs Python >= 3.11 and make, nothing else. The demo
# installs what a user gets; every other job adds the tools.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/installed
READY := $(VENV)/ready
# Modules are compiled when they are first imported: most of those that are installed never are.
PIP := $(BIN)/python -m pip install --quiet --no-compile
# Half of what is unpacked are two packages: they are unpacked beside the others. The pins are complete.
PINNED := $(PIP) --no-deps --require-hashes -r
# Compiled modules are kept: the next process, and every command that a test starts, need not compile them again.
export PYTHONDONTWRITEBYTECODE :=

.PHONY: demo test slow oldest newest long coverage power mutants fuzz torture lab lab-speed gate check bench validation docs release keep pins clean

demo: $(INSTALLED)  ## a simulated suite of rate sensors: built, run, scored
	$(BIN)/inertialcal demo

# Two workers on two cores: with two threads each, linear algebra takes twice the time.
test slow: export OMP_NUM_THREADS := 1

test: $(READY)  ## the default suite
	$(BIN)/python -m pytest -m "not slow and not bench" -n 2 --dist worksteal --benchmark-disable --durations=20

slow: $(READY)  ## a part of each long run; make coverage has all of it
	$(BIN)/python -m pytest -m "slow and not bench" -n 2 --dist worksteal --benchmark-disable --durations=20

# What is nearest to the dependencies: schemas, statistics, spectra, files, processes, certificates, the screen.
ENDS := tests/core/show tests/core/test_results_schema.py tests/statistics tests/signals/spectrum tests/sensors/chain \
	tests/files/time tests/files/binary tests/files/loggers tests/campaign/engine tests/campaign/certificate tests/cli/screen tests/kept
oldest newest: export OMP_NUM_THREADS := 1
oldest: requirements-oldest.txt  ## a part of the suite on the oldest dependencies that pyproject.toml allows
newest: requirements.txt  ## the same part on the newest, on another Python: PYTHON=python3.13
oldest newest:
	$(PYTHON) -m venv --clear build/$@
	build/$@/bin/python -m pip install --quiet --no-compile --require-hashes -r $<
	build/$@/bin/python -m pip install --quiet --no-deps --no-build-isolation -e .
	build/$@/bin/python -m pytest -m "not slow and not bench" -n 2 --dist worksteal --benchmark-disable -W error $(ENDS)

coverage: long  ## do the 95 % intervals hold the truth, n = 1,000: RIGS="npsat1 mesa", TESTS=tests/procedures/flip
	$(BIN)/python tests/coverage_runs.py $(RIGS)
	PYTHONPATH=tests OMP_NUM_THREADS=1 $(BIN)/python -m independent.coverage --n 1000 --resume
	INERTIALCAL_COVERAGE=full $(BIN)/python -m pytest -m "slow and not bench" --durations=20 $(or $(TESTS),tests)

long: $(READY)  ## a record longer than memory through allan, under 1 GiB: ROWS=1e9 (needs 20 GB of disk)
	$(BIN)/python tests/speed/long_record.py $(ROWS)

power: $(READY)  ## how often the plan of the demonstration decides: verdicts of seeds 1 to 100, half an hour; RIG= of another
	PYTHONPATH=tests/rigs OMP_NUM_THREADS=1 $(BIN)/python -m demo_power $(RIG) $(SEEDS)

mutants: $(READY)  ## wrong changes to the numerics, each of which a test must catch
	$(BIN)/python tests/mutants.py --jobs 2

fuzz: $(READY)  ## 300 files changed and 100 cut off of every reader, read with limits
	PYTHONPATH=tests/files/hostile $(BIN)/python tests/files/hostile/fuzz.py

torture: export OMP_NUM_THREADS := 1
torture: $(READY)  ## 5,000 commands on mutated inputs, kills at every file-system call: RESUME=--resume goes on
	$(BIN)/python tests/torture/torture.py $(RESUME)
	INERTIALCAL_TORTURE=full $(BIN)/python -m pytest tests/torture/test_exchange_kills.py -s --durations=20

lab: $(READY)  ## 1,000 kills and 1,000 losses of power of a recording, in slices: RESUME=--resume goes on
	PYTHONPATH=tests/lab $(BIN)/python tests/lab/lab_replays.py 1000 $(RESUME)

lab-speed: $(READY)  ## what the live page costs, and how late it is: 12 channels at 1 kHz, in chromium, a minute
	PYTHONPATH=tests/lab:tests/lab/live OMP_NUM_THREADS=1 $(BIN)/python tests/lab/live/live_speed.py 20

gate: export OMP_NUM_THREADS := 1
gate: $(READY)  ## every fault in 60 cases, 900 clean records, about an hour: RESUME=--resume goes on
	PYTHONPATH=tests $(BIN)/python -m independent.gate $(RESUME)

check: $(READY)  ## format, lint, types, manual
	$(BIN)/ruff format --check src tests docs packaging
	$(BIN)/ruff check src tests docs packaging
	$(BIN)/mypy
	$(BIN)/python docs/audit/audit.py --check
	$(BIN)/python docs/made.py --check
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs

bench: $(READY)  ## speed as ratios against named peers, the table last: LINES="kernel psd" for some, STORE=--store keeps ratios
	$(if $(LINES),,$(BIN)/python -m pytest -m bench -q -s tests)
	PYTHONPATH=tests:tests/archive $(BIN)/python -m speed $(LINES) $(STORE)

validation: $(READY)  ## results beside those of others, the page docs/validation.md: PARTS="noise peers" for some
	OMP_NUM_THREADS=1 $(BIN)/python docs/validation/validation.py $(PARTS)

docs: $(READY)
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs build/docs

release: $(READY)  ## build, check, install into an empty environment, try; TAG=--tag sets the tag of this version, INERTIALCAL_HOME=URL the links
	$(BIN)/python packaging/release.py $(TAG)

keep: $(READY)  ## files of this version, which every later one must read: tests/kept/VERSION, before its tag
	PYTHONPATH=tests:tests/campaign/certificate $(BIN)/python tests/kept/add_release.py

$(INSTALLED): requirements-run.txt pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit("inertialcal needs Python 3.11 or newer; this is " + sys.version.split()[0] + ". Try: make PYTHON=python3.11") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)
	awk '/^[a-z]/ {to = "$(VENV)/" ($$1 ~ /^(llvmlite|scipy)==/ ? "large" : "others")} {print > to}' requirements-run.txt
	$(PINNED) $(VENV)/large & $(PINNED) $(VENV)/others && wait $$!
	$(PIP) --no-deps --no-build-isolation -e .
	touch $(INSTALLED)

$(READY): requirements.txt $(INSTALLED)
	$(PIP) --require-hashes -r requirements.txt
	touch $(READY)

COMPILE = uv pip compile --quiet --universal --generate-hashes --no-header --no-emit-index-url --python-version 3.11 pyproject.toml
EXTRAS = --extra frame --extra pdf --extra sign --extra formats --extra archive --extra lab --extra fleet --extra orbit --extra web --extra test --extra build
pins:  ## needs uv; writes no address of an index
	$(COMPILE) --all-extras -o requirements.txt
	$(COMPILE) --extra build --constraint requirements.txt --no-annotate -o requirements-run.txt
	$(COMPILE) $(EXTRAS) --resolution lowest-direct --no-annotate -o requirements-oldest.txt

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis

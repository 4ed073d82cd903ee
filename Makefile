# `make demo` and `make test` do all the set-up themselves, in .venv, with the versions of constraints.txt.
PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
FAST := tests/structures tests/io tests/geometry tests/template tests/store tests/models/test_kinds.py \
	tests/models/test_config.py tests/test_cli.py tests/test_docs.py tests/test_house.py tests/test_public.py
VALIDATOR := tests/gltf_validator
VALIDATOR_STAMP := $(VALIDATOR)/node_modules/.package-lock.json

.PHONY: demo test slow fast fuzz lint docs results results-long setup clean

demo: setup examples/astronaut/astronaut.png
	$(BIN)/caricli portrait examples/astronaut/astronaut.png --out-dir demo --overwrite

# One numerical thread for each of the two test processes.
test: setup $(VALIDATOR_STAMP)
	@command -v chromium > /dev/null || command -v chromium-browser > /dev/null || command -v google-chrome > /dev/null \
	|| echo "Chromium is not installed: the tests play no films and draw no rigs in a browser, and do not open the studio"
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadfile -m "not slow"

# Pipelines, examples and docs/own_head.md from nothing to their ends; how far some networks learn, more drawings, longer
# fuzzing: what they call is tested by `make test`, too.
slow: setup
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist load -m slow

# Hardly any training or rendering: under a minute, for every few lines that are changed.
fast: setup
	OMP_NUM_THREADS=1 $(BIN)/python -m pytest -q -n 2 --durations=0 --durations-min=5 $(FAST)

# All readers for so many seconds, e.g. `make fuzz SECONDS=36000`; .fuzz keeps what was learnt, and the findings.
SECONDS ?= 600
fuzz: setup
	OMP_NUM_THREADS=1 $(BIN)/python -m tests.fuzz --seconds $(SECONDS) --folder .fuzz

# Also what pre-commit runs, by .pre-commit-config.yaml.
lint: setup
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/lint-imports --no-cache
	$(BIN)/python docs/generate_cli.py --check
	$(BIN)/python -m pytest -q tests/test_docs.py

docs: setup
	$(BIN)/python docs/generate_cli.py

# The tables of benchmarks/RESULTS.md, with the runs that are short (benchmarks/tables.yaml): the same figures every
# time. The long ones are hours; stopped, they go on with the next.
results: setup
	$(BIN)/python -m benchmarks.results

results-long: setup
	$(BIN)/python -m benchmarks.results --long

setup: $(VENV)/installed

# The build backend is installed first and by its pin, so that nothing is built with an unlocked one.
$(VENV)/installed: pyproject.toml setup.py constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet -c constraints.txt setuptools
	$(BIN)/python -m pip install --quiet --no-build-isolation -c constraints.txt -e '.[dev]'
	touch $@

$(VALIDATOR_STAMP): $(VALIDATOR)/package.json $(VALIDATOR)/package-lock.json
	@if command -v npm > /dev/null; then (cd $(VALIDATOR) && npm ci --loglevel=error --no-audit --no-fund) && touch $@; \
	else echo "npm is not installed: the tests do not validate GLB files"; fi

examples/astronaut/astronaut.png: examples/astronaut/fetch_image.py | setup
	$(BIN)/python $< $@

clean:
	rm -rf $(VENV) .fuzz demo build dist *.egg-info examples/astronaut/astronaut.png $(VALIDATOR)/node_modules

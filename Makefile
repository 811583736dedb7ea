# Everything here sets itself up: Python 3.11 or later with venv, and make, are all that a machine needs.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/.ready
FRESH := build/fresh
SCENARIOS := scenarios/town scenarios/highway scenarios/sharp_turns scenarios/slow_curve
DETECTORS := chi_square cusum isolation_forest lstm lstm_glr lstm_cusum innovation joint separation

.PHONY: help setup constraints fleet-eval closed-loop closed-loop-claims bench soak leaderboard paper-tables train calibrate nets docs test test-all fuzz lint check clean

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 14

setup: $(READY) ## make the virtual environment

$(READY): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
	touch $(READY)

constraints: ## install the newest versions in a fresh environment, and write them into constraints.txt
	rm -rf $(FRESH)
	$(PYTHON) -m venv $(FRESH)
	$(FRESH)/bin/pip install --quiet --disable-pip-version-check --editable '.[dev]'
	sed -n '/^#/p' constraints.txt > $(FRESH)/constraints.txt
	$(FRESH)/bin/pip freeze --exclude-editable | sed 's/+cpu$$//' >> $(FRESH)/constraints.txt
	mv $(FRESH)/constraints.txt constraints.txt
	rm -rf $(FRESH)

fleet-eval: $(READY) ## run the four evaluation scenarios into results/fleet-eval
	$(BIN)/gpsec run $(SCENARIOS) --out results/fleet-eval --overwrite

closed-loop: $(READY) ## let town and highway steer by their estimates, and show what stealth does to the traffic
	$(BIN)/gpsec run scenarios/town scenarios/highway --closed-loop --duration 120 \
		--set 'closed_loop.worlds=[{plan="stealth"},{plan="stealth",defence="lstm_glr+ukf"}]' \
		--out results/closed-loop --overwrite

closed-loop-claims: $(READY) ## what claims of the closed loop need, into results/claims; goes on where it stopped
	$(BIN)/gpsec run scenarios/town scenarios/highway --closed-loop --duration 360 --seeds 1-5 --resume \
		--set 'closed_loop.worlds=[{}]' --set closed_loop.steer=all --out results/claims/benign
	$(BIN)/gpsec run scenarios/town scenarios/highway --closed-loop --duration 120 --seeds 1-10 --resume \
		--set 'closed_loop.worlds=[{plan="stealth"}]' --out results/claims/stealth
	$(BIN)/gpsec run scenarios/town --inject-false-alarms 1,5,25 --duration 180 --seeds 1-10 --resume \
		--set fleet.profile=carla --out results/claims/false-alarms
	$(BIN)/python -m benchmarks.event_rates results/claims/stealth
	$(BIN)/python -m benchmarks.event_rates results/claims/false-alarms

bench: $(READY) ## measure what it costs, against bare SUMO, into results/bench.json
	$(BIN)/python -m benchmarks

soak: $(READY) ## run a city for ten million vehicle-steps and watch memory, into results/soak.json
	$(BIN)/python -m benchmarks.soak

leaderboard: $(READY) ## put all detectors through the suite of gpsec bench-detector, into results/reference/leaderboard.csv
	$(BIN)/gpsec bench-detector $(DETECTORS) --out results/leaderboard
	cp results/leaderboard/leaderboard.csv results/reference/leaderboard.csv

paper-tables: $(READY) ## re-create the paper's tables in results/paper; goes on where it stopped
	$(BIN)/gpsec paper

train: $(READY) ## train and calibrate the detectors into gpsec/models
	$(BIN)/gpsec train --out gpsec/models

calibrate: $(READY) ## calibrate rare false alarms of gpsec/models on 1,000 vehicle-hours each; goes on where it stopped
	$(BIN)/gpsec calibrate --out gpsec/models

nets: $(READY) ## rebuild the road networks in sumo_nets
	$(BIN)/python -m sumo_nets.build

docs: $(READY) ## make the documentation site in build/site
	$(BIN)/mkdocs build

test: $(READY) ## run the tests
	$(BIN)/pytest -n auto --dist loadfile

test-all: $(READY) ## run the slow tests, too
	$(BIN)/pytest -n auto --dist loadfile -m 'slow or not slow'

fuzz: $(READY) ## damage what is read, 100,000 times; what fails is kept in build/fuzz
	$(BIN)/python -m tests.fuzz

lint: $(READY) ## look at the code without running it
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python .ci/commits.py

check: lint test ## all that must pass before a change lands

clean: ## remove the environment and what tools left behind
	rm -rf $(VENV) build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache \
		benchmarks/.built

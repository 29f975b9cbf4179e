# make demo and make test set up all they need in a virtual environment in this folder.
# PYTHON=python3.12 make test takes another Python.

PYTHON ?= python3
VENV ?= .venv
BIN := $(VENV)/bin
VERSION := $(shell $(PYTHON) -c 'import platform; print(platform.python_version())' 2>/dev/null)
DEMO := $(VENV)/.demo-$(VERSION)
READY := $(VENV)/.ready-$(VERSION)
UV := $(shell command -v uv 2>/dev/null)
INSTALL := $(if $(UV),$(UV) pip install --quiet --python $(BIN)/python,$(BIN)/python -m pip install --quiet --disable-pip-version-check)

.DEFAULT_GOAL := help
.PHONY: help demo install test test-slow test-portable test-all system system-package system-container system-gpio system-loopback system-arm64 system-deploy system-firmware system-coppeliasim system-vrep lint types rules package docs coverage check clean

help:  ## list the targets
	@grep -hE '^[a-z0-9-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 14

$(DEMO): pyproject.toml
	@if [ -d $(VENV) ] && ! ls $(VENV)/.ready-* $(VENV)/.by-make >/dev/null 2>&1; then \
		echo "$(VENV) is not from make, so make does not replace it. Use another folder: make VENV=.venv-make ..."; exit 1; fi
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
		{ echo "robotcore needs Python 3.10 or newer; $(PYTHON) is $$($(PYTHON) --version). Try: PYTHON=python3.11 make ..."; exit 1; }
	@echo "Setting up $(VENV) with $(if $(UV),uv,pip) for the demo ..."
	@$(if $(UV),$(UV) venv --quiet --clear --python $(PYTHON) $(VENV),$(PYTHON) -m venv --clear $(VENV))
	@touch $(VENV)/.by-make
	@$(INSTALL) -e '.[demo]'
	@touch $@

$(READY): $(DEMO)
	@echo "Installing the rest into $(VENV), for the tests ..."
	@$(INSTALL) -e '.[dev]'
	@touch $@

demo: $(DEMO)  ## watch the robot find the green ball; leaves demo.png
	@$(BIN)/robotcore demo

install: $(READY)  ## install robotcore with everything into .venv

test: $(READY)  ## run the quick tests, on all cores
	@$(BIN)/python -m pytest -n auto --dist worksteal -m 'not slow' $(ARGS)

test-slow: $(READY)  ## run the slow tests: whole runs, processes, servers and ssh
	@$(BIN)/python -m pytest -n auto --dist worksteal -m slow $(ARGS)

test-portable: $(READY)  ## run the quick tests of the core while POSIX is hidden, as on Windows
	@$(BIN)/python -m pytest -p tests.no_posix -n auto --dist worksteal -m 'not slow' $(ARGS) @tests/portable.txt

test-all:  ## run the quick tests on every Python from 3.10 to 3.13 that is on this machine
	@for version in 3.10 3.11 3.12 3.13; do \
		if python$$version --version >/dev/null 2>&1; then \
			echo "== Python $$version"; \
			$(MAKE) --no-print-directory test PYTHON=python$$version VENV=.venv-$$version || exit 1; \
		else echo "== Python $$version is not on this machine"; fi; \
	done

system: system-package system-container system-gpio system-loopback system-arm64 system-deploy system-firmware system-coppeliasim system-vrep  ## the tests on other machines and on real simulators, where they can run

system-package: $(READY)  ## install the wheel and the source distribution in new environments, and use them
	@$(BIN)/python -m tests.system.package || [ $$? -eq 77 ]

system-container: $(READY)  ## build the container, and run apps in it
	@$(BIN)/python -m tests.system.container || [ $$? -eq 77 ]

system-gpio: $(READY)  ## test the Pi's drivers on a real kernel's GPIO chip and camera, in QEMU
	@$(BIN)/python -m tests.system.gpio || [ $$? -eq 77 ]

system-loopback: $(READY)  ## test doctor --loopback on such a chip, whose lines are connected as by two wires
	@$(BIN)/python -m tests.system.gpio loopback || [ $$? -eq 77 ]

system-arm64: $(READY)  ## test the wheel on an emulated arm64
	@$(BIN)/python -m tests.system.arm64 || [ $$? -eq 77 ]

system-deploy: $(READY)  ## deploy to a Debian that systemd boots
	@$(BIN)/python -m tests.system.deploy || [ $$? -eq 77 ]

system-firmware: $(READY)  ## test the firmware on a simulated AVR, with the drivers that speak to it
	@$(BIN)/python -m tests.system.firmware || [ $$? -eq 77 ]

system-coppeliasim: $(READY)  ## test coppeliasim on a real CoppeliaSim: ROBOTCORE_COPPELIASIM=HOST:PORT
	@$(BIN)/python -m tests.system.coppeliasim || [ $$? -eq 77 ]

# Both use one simulator, so vrep waits for coppeliasim if make runs both.
system-vrep: $(READY) | $(filter system-coppeliasim,$(MAKECMDGOALS:system=system-coppeliasim))  ## test vrep on a real simulator: ROBOTCORE_VREP=HOST:PORT, and ROBOTCORE_COPPELIASIM of the same
	@$(BIN)/python -m tests.system.vrep || [ $$? -eq 77 ]

lint: $(READY)  ## style: ruff
	@$(BIN)/ruff check . && $(BIN)/ruff format --check .

types: $(READY)  ## types: mypy, strict
	@$(BIN)/mypy

rules: $(READY)  ## who may import whom: import-linter
	@$(BIN)/lint-imports

package: $(READY)  ## build the source distribution and from it the wheel, and check its content
	@rm -rf dist && $(BIN)/python -m build --quiet --installer $(if $(UV),uv,pip) >/dev/null && $(BIN)/check-wheel-contents dist

# The variable hides an advertisement of the theme.
docs: $(READY)  ## build the documentation site in site/; open site/index.html
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build --quiet --strict

coverage: $(READY)  ## run all tests with branch coverage
	@$(BIN)/python -m pytest -n auto --dist worksteal --cov --cov-report=term:skip-covered

check: lint types rules package docs coverage  ## all that CI does, but for the system tests

clean:  ## remove the built files
	@rm -rf .venv .venv-* dist build site .coverage* .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache

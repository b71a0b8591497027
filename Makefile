# Without ROS 2: `make run` shows the paper's figure 7, `make test` checks everything.
# Both set up .venv first. With ROS 2 Jazzy use colcon and `ros2 run`; see README.md.

PYTHON ?= $(shell for p in python3.12 python3.11 python3; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null \
	&& echo $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := src/bdt_msgs_py src/bdt_plant src/bdt_controller src/bdt_twin src/bdt_bringup
SOURCES := src tests embedded_ros

.PHONY: run test conformance setup check tables lock

run: setup
	$(BIN)/bdt run --config config/paper.yaml

test: check
	$(BIN)/python -m pytest

# The documented behavior of rclpy: that of a ROS 2 that is sourced, else that of embedded_ros.
conformance:
	@if python3 -c 'import rclpy' 2>/dev/null; then python=python3; \
	else $(MAKE) --no-print-directory setup && python=$(BIN)/python; fi && \
	PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 $$python -m pytest --confcutdir=tests/conformance tests/conformance

check: setup
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/mypy

setup: $(VENV)/.ready

$(VENV)/.ready: requirements.lock $(wildcard src/*/setup.py) embedded_ros/pyproject.toml
	@test -n "$(PYTHON)" || { echo "error: Python 3.11 or 3.12 is needed (PYTHON=/path/to/python)"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	@# A sourced ROS 2 brings its own rclpy; embedded_ros is for machines that have none.
	$(BIN)/python -c 'import rclpy' 2>/dev/null || $(BIN)/python -m pip install --quiet \
		--disable-pip-version-check --use-pep517 --no-deps --no-build-isolation -e embedded_ros
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --use-pep517 --no-deps \
		--no-build-isolation $(addprefix -e ,$(PACKAGES))
	touch $@

# Prints the tables of topics and parameters in README.md.
tables: setup
	@$(BIN)/python -m bdt_bringup.running.interface_tables

# Resolves requirements.in anew; the lock file holds hashes and names no index.
lock:
	$(PYTHON) -m venv $(VENV)-lock
	$(VENV)-lock/bin/python -m pip install --quiet pip-tools
	$(VENV)-lock/bin/pip-compile --quiet --upgrade --generate-hashes --allow-unsafe --strip-extras \
		--no-header --no-emit-index-url --no-emit-trusted-host --no-emit-find-links \
		--output-file requirements.lock requirements.in
	rm -r $(VENV)-lock

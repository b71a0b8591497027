# Without ROS 2: `make run` shows the paper's figure 7, `make test` checks everything.
# Both set up .venv first. With ROS 2 Jazzy use colcon and `ros2 run`; see README.md.

PYTHON ?= $(shell for p in python3.12 python3.11 python3; do \
	$$p -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 12))' 2>/dev/null \
	&& echo $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := $(addprefix src/,bdt_msgs_py bdt_plant bdt_controller bdt_driver bdt_serial_drive bdt_drive_emulator bdt_twin bdt_bags bdt_analysis bdt_study bdt_bringup bdt_live)
SOURCES := src tests embedded_ros checks docs/make_figures.py docs/live_pictures.py docs/source/conf.py docs/source/extensions

# Tests of one file share what they set up, so a file stays with one process. Most tests wait now and
# then: there is one process more than processors. Loops in real time come after them, one by one: they
# are several processes each.
BY_FILE := --dist loadfile --no-loadscope-reorder
PROCESSES := $(shell n=$$(nproc); echo $$((n < 4 ? n + 1 : 4)))
define run_tests
	$(1)/python -m pytest --numprocesses $(PROCESSES) $(BY_FILE) -m "not real_time"
	$(1)/python -m pytest -m real_time
endef

.PHONY: run hardware test test-noble conformance stray-messages soak setup check docs figures dist dist-test version lock

# DURATION=40 runs 40 s of the scenario's 120.
run: setup
	$(BIN)/bdt run --config config/paper.yaml $(if $(DURATION),--duration $(DURATION))

# A drive behind a pseudo-terminal: all points of `bdt hardware-check`, then a loop of a minute on it.
hardware: setup
	$(BIN)/python -m checks.emulated_hardware $(if $(DURATION),--duration $(DURATION))

test: check $(VENV)/.docs-ready
	$(call run_tests,$(BIN))

# The tests with the versions that Ubuntu 24.04 ships, in an environment of its own.
test-noble:
	$(MAKE) --no-print-directory setup VENV=.venv-noble PYTHON=python3.11 VERSIONS=requirements-noble.txt
	$(call run_tests,.venv-noble/bin)

# The documented behavior of rclpy: that of a ROS 2 that is sourced, else that of embedded_ros.
conformance:
	@if python3 -c 'import rclpy' 2>/dev/null; then python=python3; \
	else $(MAKE) --no-print-directory setup && python=$(BIN)/python; fi && \
	PYTEST_DISABLE_PLUGIN_AUTOLOAD=1 $$python -m pytest --confcutdir=tests/conformance tests/conformance

# What each node does about messages that do not belong, as a page of the documentation.
stray-messages: setup
	WRITE_STRAY_MESSAGES=1 $(BIN)/python -m pytest tests/test_stray_messages.py

# The loop for long, as fast as it goes and in real time; then loops under random schedules of faults,
# a few seconds each with the plant and 30 s with an emulated machine: SCHEDULES and MACHINES of them
# from SEED on, the former JOBS at a time. With the same RESULTS the schedules go on where they ended;
# PERIODS=0 leaves the long loop out.
PERIODS ?= 1e7
SCHEDULES ?= 10000
MACHINES ?= 1000
SEED ?= 0
RESULTS ?= soak.txt
JOBS ?= $(shell nproc)
soak: setup
ifneq ($(PERIODS),0)
	$(BIN)/python tests/faults/endurance.py --periods $(PERIODS)
	$(BIN)/python tests/faults/endurance.py --real-time --periods 1.8e6
endif
	$(BIN)/python tests/faults/soak.py --count $(SCHEDULES) --begin $(SEED) --results $(RESULTS) \
		--jobs $(JOBS)
	$(BIN)/python tests/faults/soak.py --machine --count $(MACHINES) --begin $(SEED) \
		--results machine-$(RESULTS)

check: setup
	$(BIN)/ruff check $(SOURCES)
	$(BIN)/ruff format --check $(SOURCES)
	$(BIN)/mypy
	PYTHONPATH=embedded_ros/src $(BIN)/lint-imports --no-logo --no-cache
	$(BIN)/python -m checks.check_dependencies
	$(BIN)/python -m checks.package_versions

setup: $(VENV)/.ready

$(VENV)/.ready: requirements.lock $(VERSIONS) $(wildcard src/*/setup.py src/*/package.xml) embedded_ros/pyproject.toml
	@test -n "$(PYTHON)" || { echo "error: Python 3.11 or 3.12 is needed (PYTHON=/path/to/python)"; exit 2; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	@# A sourced ROS 2 brings its own rclpy; embedded_ros is for machines that have none.
	$(BIN)/python -c 'import rclpy' 2>/dev/null || $(BIN)/python -m pip install --quiet \
		--disable-pip-version-check --use-pep517 --no-deps --no-build-isolation -e embedded_ros
	@# From here on with the versions asked for; embedded_ros is never built with those of a ROS 2.
	$(if $(VERSIONS),$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps -r $(VERSIONS))
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --use-pep517 --no-deps \
		--no-build-isolation $(addprefix -e ,$(PACKAGES))
	touch $@

# The documentation in docs/build/html; a warning is an error, and nothing is loaded from a network.
docs: $(VENV)/.docs-ready
	$(BIN)/python -m sphinx --quiet --jobs 2 --fail-on-warning --keep-going \
		--builder html docs/source docs/build/html
	@echo "documentation: docs/build/html/index.html"

# What only the documentation needs is no part of `make setup`: it is a fifth of the wait for a first run.
$(VENV)/.docs-ready: $(VENV)/.ready requirements-docs.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-docs.lock
	touch $@

# Draws the pictures of README and documentation anew, all but those of other people's programs.
figures: setup
	$(BIN)/python docs/make_figures.py

# A wheel for each package, one for embedded_ros and one that depends on all packages. What an earlier
# build left would get into them: setuptools packs the whole of its build folder.
dist: setup
	rm -rf dist $(addsuffix /build,. $(PACKAGES) embedded_ros)
	umask 022 && SOURCE_DATE_EPOCH=$$(git log -1 --format=%ct 2>/dev/null || echo 1700000000) \
		$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --use-pep517 --no-deps --no-index \
		--no-build-isolation --wheel-dir dist $(addprefix ./,$(PACKAGES)) ./embedded_ros .
	rm -rf $(addsuffix /build,. $(PACKAGES) embedded_ros) *.egg-info

# The wheels in an empty environment outside the repository.
dist-test: dist
	checks/run_from_wheels.sh

# Writes the version of all packages: make version VERSION=0.2.0
version:
	$(BIN)/python -m checks.package_versions $(VERSION)

# Resolves requirements.in anew, and requirements-docs.in beside it; locks hold hashes and name no index.
lock:
	$(PYTHON) -m venv $(VENV)-lock
	$(VENV)-lock/bin/python -m pip install --quiet pip-tools
	for set in requirements requirements-docs; do \
		$(VENV)-lock/bin/pip-compile --quiet --upgrade --generate-hashes --allow-unsafe --strip-extras \
			--no-header --no-emit-index-url --no-emit-trusted-host --no-emit-find-links \
			--output-file $$set.lock $$set.in || exit 1; done
	rm -r $(VENV)-lock

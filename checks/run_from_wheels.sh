#!/usr/bin/env bash
# Installs the wheels in dist/ into an empty environment outside the repository and runs the program
# from there: what a user has who never saw the repository.
set -euo pipefail
cd "$(dirname "$0")/.."
repository=$PWD
python=$repository/.venv/bin/python
outside=$(mktemp -d)
trap 'rm -rf "$outside"' EXIT

# Third-party packages with the hashes of the lock, then ours from dist/ and from nowhere else.
"$python" -m venv --without-pip "$outside/env"
"$python" -m checks.locked_requirements bdt_bringup bdt_live bdt_study bdt_drive_emulator bdt_serial_drive embedded_ros >"$outside/requirements.txt"
pip=("$python" -m pip --quiet --disable-pip-version-check --python "$outside/env/bin/python" install --no-compile)
"${pip[@]}" --no-deps --require-hashes -r "$outside/requirements.txt"
"${pip[@]}" --no-index --find-links dist "backlash-digital-twin[embedded-ros]"

cd "$outside"
# What is started is compiled once, not anew by each process, whatever a developer has set.
unset PYTHONDONTWRITEBYTECODE PYTHONPATH
export PATH="$outside/env/bin:$PATH"
export ROS_DOMAIN_ID=$((1 + $$ % 100)) ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST
bdt --help
ros2 pkg executables
ros2 run bdt_bringup bdt run --config paper --duration 10 --output run
test -s run/report.html

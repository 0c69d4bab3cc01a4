#!/usr/bin/env bash
# Installs what is missing, builds, runs the tests. Arguments go to ctest:
#   bash tests/run.sh             everything
#   bash tests/run.sh -L fast     the loop of development
#   bash tests/run.sh -R Digest   tests whose name matches
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/../.ci/setup.sh"
phiz_install_packages
phiz_build
cd "$PHIZ_BUILD"
exec ctest --output-on-failure --no-tests=error -j "$PHIZ_JOBS" "$@"

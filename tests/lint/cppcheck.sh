#!/usr/bin/env bash
# cppcheck over our own code. Each suppression has its reason.
set -euo pipefail
cd "$(dirname "$0")/../.."
options=(
  --enable=warning,performance,portability
  --error-exitcode=1 --inline-suppr --quiet --language=c++ --std=c++20 --max-configs=1 -j "$(nproc)"
  -I . -DHWY_ONCE=1
  --suppress=unknownMacro                 # Highway's and GoogleTest's macros
  --suppress=syntaxError                  # of cppcheck 2.10, at C++20 it does not know
  --suppress=internalAstError             # the same
  --suppress=containerOutOfBounds         # guesses sizes that are computed
  --suppress=normalCheckLevelMaxBranches  # cppcheck 2.17 says where it stops
  --suppress=uninitMemberVar              # aggregates that are filled before use
)
exec cppcheck "${options[@]}" algo hal firmware_like tools

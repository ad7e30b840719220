#!/usr/bin/env bash
# Every C++ file is as .clang-format would have it; says which are not, and how to mend them.
set -euo pipefail
cd "$(dirname "$0")/../.."
mapfile -t files < <(find algo hal firmware_like tests tools -name '*.cpp' -o -name '*.hpp' | sort)
if ! clang-format --dry-run -Werror "${files[@]}" 2>/dev/null; then
  for file in "${files[@]}"; do
    clang-format --dry-run -Werror "$file" 2>/dev/null || echo "not formatted: $file (clang-format -i $file)"
  done
  exit 1
fi

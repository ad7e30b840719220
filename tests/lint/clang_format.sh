#!/usr/bin/env bash
# Every C++ file is as .clang-format would have it; says which are not, and how to mend them. Versions break lines each in
# its own way, so only one judges: 14, Debian 12's. Skipped (77) where there is another.
set -euo pipefail
cd "$(dirname "$0")/../.."
version=$(clang-format --version)
if ! [[ $version =~ version\ 14\. ]]; then
  echo "skipped: clang-format 14 judges, and this is $version"
  exit 77
fi
mapfile -t files < <(find algo hal firmware_like tests tools -name '*.cpp' -o -name '*.hpp' | sort)
if ! clang-format --dry-run -Werror "${files[@]}" 2>/dev/null; then
  for file in "${files[@]}"; do
    clang-format --dry-run -Werror "$file" 2>/dev/null || echo "not formatted: $file (clang-format -i $file)"
  done
  exit 1
fi

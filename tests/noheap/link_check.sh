#!/usr/bin/env bash
# Fails where a controller library refers to an allocator, an exception, a stream, or a function of libm whose last
# bit differs between machines; or holds an instruction that fuses multiplication and addition.
#
#   link_check.sh NM OBJDUMP LIBRARY...
set -euo pipefail
nm=$1
objdump=$2
shift 2
forbidden='operator new|operator delete|\b(malloc|calloc|realloc|free|aligned_alloc|posix_memalign|strdup)$'
forbidden+='|__cxa_throw|__cxa_allocate_exception|std::__throw_|std::(basic_)?(o|i)stream|std::cout|std::basic_string'
forbidden+='|\b(sin|cos|tan|asin|acos|atan|atan2|exp|exp2|log|log2|log10|pow|cbrt|hypot|fma|sincos)f?$'
fused='\b(vfn?m(add|sub)[0-9a-z]*|fn?m(add|sub)|fml[as])\b'
bad=0
for library in "$@"; do
  if symbols=$("$nm" -C --undefined-only "$library" | grep -E "$forbidden"); then
    echo "$library refers to what the controller must not use:"
    sort -u <<<"$symbols"
    bad=1
  fi
  if instructions=$("$objdump" -d --no-show-raw-insn "$library" | grep -E "$fused" | head -5); then
    echo "$library fuses multiplication and addition:"
    echo "$instructions"
    bad=1
  fi
done
exit $bad

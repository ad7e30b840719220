// Loops for the processor that is there: the same operations side by side, eight or sixteen at a time instead
// of four, and so the same bits (none are fused: cmake/flags.cmake).
#pragma once

// Put before a function whose loops take most of the time.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define VERGENCE_WIDE __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define VERGENCE_WIDE
#endif

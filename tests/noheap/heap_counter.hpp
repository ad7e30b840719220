// Counts calls of the allocator while one of these lives: proof that a block of code uses no heap.
#pragma once

namespace vergence::testing {

class HeapCounter {
 public:
  HeapCounter();
  ~HeapCounter();
  HeapCounter(const HeapCounter&) = delete;
  HeapCounter& operator=(const HeapCounter&) = delete;

  [[nodiscard]] long calls() const;  // of malloc, calloc, realloc, free and their kin since construction
};

}  // namespace vergence::testing

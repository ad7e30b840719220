// Counts calls of the allocator, and of those that map memory, while one of these lives: proof that a block
// of code asks for no memory.
#pragma once

namespace vergence::testing {

class HeapCounter {
 public:
  HeapCounter();
  ~HeapCounter();
  HeapCounter(const HeapCounter&) = delete;
  HeapCounter& operator=(const HeapCounter&) = delete;

  [[nodiscard]] long calls() const;  // of malloc, free, mmap, brk and their kin since construction
};

}  // namespace vergence::testing

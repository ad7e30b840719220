// Independent pieces of work, shared by threads.
#pragma once

#include <cstddef>
#include <functional>

namespace vergence::tools {

// Calls work(0) .. work(count - 1), each once, on up to `threads` threads (0: all cores). Rethrows the first
// exception after all have ended; pieces not begun by then are left out.
void in_parallel(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace vergence::tools

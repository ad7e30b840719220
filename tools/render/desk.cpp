#include "tools/render/desk.hpp"

#include <mutex>
#include <utility>

namespace vergence::render {
namespace {

struct FreeDesks {
  std::mutex mutex;
  std::vector<std::unique_ptr<Desk>> desks;
};

FreeDesks& free_desks() {
  static FreeDesks all;
  return all;
}

}  // namespace

DeskLoan::DeskLoan() {
  FreeDesks& free = free_desks();
  {
    const std::scoped_lock lock(free.mutex);
    if (!free.desks.empty()) {
      desk_ = std::move(free.desks.back());
      free.desks.pop_back();
    }
  }
  if (!desk_) desk_ = std::make_unique<Desk>();
}

DeskLoan::~DeskLoan() {
  // Left in the middle of a picture it is not as the next one expects it.
  if (std::uncaught_exceptions() > exceptions_) return;
  FreeDesks& free = free_desks();
  const std::scoped_lock lock(free.mutex);
  free.desks.push_back(std::move(desk_));
}

}  // namespace vergence::render

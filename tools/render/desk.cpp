#include "tools/render/desk.hpp"

#include <mutex>
#include <utility>

namespace vergence::render {
namespace {

std::mutex mutex;
std::vector<std::unique_ptr<Desk>> free_desks;

}  // namespace

DeskLoan::DeskLoan() {
  {
    const std::scoped_lock lock(mutex);
    if (!free_desks.empty()) {
      desk_ = std::move(free_desks.back());
      free_desks.pop_back();
    }
  }
  if (!desk_) desk_ = std::make_unique<Desk>();
}

DeskLoan::~DeskLoan() {
  const std::scoped_lock lock(mutex);
  free_desks.push_back(std::move(desk_));
}

}  // namespace vergence::render

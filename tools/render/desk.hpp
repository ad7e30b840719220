// The memory a picture is made in. It is kept for the next one: fresh pages take as long as drawing on them.
#pragma once

#include <exception>
#include <memory>
#include <vector>

#include "tools/render/linear_image.hpp"
#include "tools/render/rasteriser.hpp"

namespace vergence::render {

struct Desk {
  LinearImage image;
  LinearImage sum;  // over the exposure
  std::vector<float> glints;
  std::vector<Placed> placed;
  Visibility visibility;
  Rasteriser rasteriser;
};

// A desk of one's own, as long as the loan lives. Threads come and go, so desks belong to none of them.
class DeskLoan {
 public:
  DeskLoan();
  ~DeskLoan();
  DeskLoan(const DeskLoan&) = delete;
  DeskLoan& operator=(const DeskLoan&) = delete;

  Desk& operator*() const { return *desk_; }
  Desk* operator->() const { return desk_.get(); }

 private:
  std::unique_ptr<Desk> desk_;
  int exceptions_ = std::uncaught_exceptions();
};

}  // namespace vergence::render
